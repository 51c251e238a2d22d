"""The scripts of the loaded scene: which of them are running, and when their functions are called.

A **child script** runs from start to stop, a **main script** too; a **customization script** runs from the load of
the scene to its close, whether the simulation runs or not.

| when | main and child scripts | customization scripts |
|---|---|---|
| scene loaded, object added | (added while running: as at start) | `sysCall_init` |
| each idle cycle while stopped | | `sysCall_nonSimulation`, threads |
| start, before the state is saved | | `sysCall_beforeSimulation` |
| start | `sysCall_init` | |
| before each simulation step, which it may refuse | `sysCall_beforeMainScript` | the same |
| each simulation step before physics | threads, then `sysCall_actuation` | the same, after the child scripts |
| before and after each physics step | `sysCall_dynCallback` | the same |
| two shapes come near each other | `sysCall_contactCallback`, once | the same, if it is left to others |
| before each physics step | `sysCall_jointCallback` or `sysCall_joint` of a joint | the same, if there is none |
| after actuation | `sysCall_joint` of a kinematic joint that has a target | the same, if there is none |
| each image, each detection of a sensor | `sysCall_vision`, `sysCall_trigger` | the same, if there is none |
| after sensing, and each idle cycle | `sysCall_event`, if there are events | the same |
| each simulation step after physics | `sysCall_sensing` | the same, after the child scripts |
| pause; each idle cycle then; continue | `sysCall_suspend`, `sysCall_suspended`, `sysCall_resume` | the same |
| stop, before the state is restored | threads once more, `sysCall_cleanup` | |
| stop, after that | | `sysCall_afterSimulation` |
| objects made, copied or removed | `sysCall_afterCreate` and its like, see `callbacks/objects.py` | the same |
| scene loaded, after `sysCall_init` | | `sysCall_afterLoad` |
| scene saved; selection changed | `sysCall_beforeSave`, `sysCall_afterSave`; `sysCall_selChange` | the same |
| scene closed, object removed | (object removed: no call) | `sysCall_cleanup` |

The contact call-back is called once per pair and simulation step.

Scripts deeper in the tree are called first, children in their order before their parent, as in V-REP's default order;
`calling_order.py` has the exceptions.
Throughout a simulation step, also in sensing, simulated time is that of its start. With a main script, the child
scripts' actuation and sensing run when it calls ``sim.handleChildScripts``; physics runs between the two in any case.

An error in one of these ends that script until the next start (a customization script: until the scene is loaded
again); an error in a function that a client calls is reported only to that client.
"""

from __future__ import annotations

import logging
import time
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Protocol, cast

from .callbacks.joints import JointCallBacks
from .callbacks.objects import ObjectCallBacks
from .callbacks.outside import OutsideCalls
from .callbacks.physics import PhysicsCallBacks
from .callbacks.vision import VisionCallBacks
from .calling_order import Called
from .interpreter import ACTUATION, SENSING
from .lives import Lives
from .script import Script, ScriptKind
from .told_once import ToldOnce

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar
    from simx_server.sensors.force import ForceSensors
    from simx_server.sensors.proximity.proximity import ProximitySensors
    from simx_server.sensors.vision.vision_sensors import VisionSensors
    from simx_server.simulation.simulation import Simulation


logger = logging.getLogger(__name__)

EVENT = "sysCall_event"

BEFORE = "sysCall_beforeMainScript"

_LIST, _END = b"\x9f", b"\xff"
"""Start and end of a list in CBOR whose length is not known."""

_SCHEDULED = attrgetter("scheduled")

_IDLE_FUNCTIONS = ("sysCall_nonSimulation", "sysCall_suspended", EVENT)


def _refuses(answer: list[Any] | None) -> bool:
    given: Any = answer[0] if answer else None
    return isinstance(given, dict) and bool(cast("dict[str, Any]", given).get("doNotRunMainScript"))


class ListOfScripts(Protocol):
    """The scripts of the scene; see `scripts.Scripts`."""

    def of(self, owner: int, kind: ScriptKind) -> Script | None: ...
    def called(self) -> Called: ...
    def notify(self, owner: int, function: str, *arguments: Any) -> list[Any] | None: ...


class Phases:
    """Calls the scripts of a scene in their phases."""

    def __init__(
        self,
        sim: Simulation,
        scripts: ListOfScripts,
        lives: Lives,
        told_once: ToldOnce,
        status_bar: StatusBar,
        vision: VisionSensors,
        proximity: ProximitySensors,
        force: ForceSensors,
    ) -> None:
        self._sim = sim
        self._status_bar = status_bar
        self._wants_idle = False
        """Whether a script has a function or thread that runs while the simulation is stopped or paused."""
        self._scripts = scripts
        self._handled: set[str] = set()
        """Phases in which a main script has called the customization scripts."""
        self._guards: list[Script] = []
        """Scripts that may refuse a simulation step."""
        self._watched: tuple[Script, ...] = ()
        """Scripts with which the lists of call-backs were made."""
        self._lives = lives
        self._joints = JointCallBacks(sim, lives, status_bar)
        self._vision = VisionCallBacks(sim, scripts.notify, status_bar, vision, proximity, force)
        self._physics = PhysicsCallBacks(sim, lives)
        self.objects = ObjectCallBacks(sim, self.call_all, told_once.tell)
        """Call-backs for objects that are made, copied and removed."""
        self.outside = OutsideCalls(self._outside_changed)
        """Call-backs of clients, which come after those of the scripts."""

    @property
    def has_work(self) -> bool:
        """Return whether the scene has scripts."""
        return bool(self._scripts.called().every) or self.outside.has()

    def refuse_step(self) -> bool:
        """Call `sysCall_beforeMainScript`; return whether a script's answer is {doNotRunMainScript = true}."""
        if not self._guards:
            return False
        answers = [self._lives.call(script, BEFORE) for script in self._guards]
        return any(map(_refuses, answers))

    def actuate(self) -> None:
        """Run threads and actuation, before physics."""
        self._physics.forget_answers()
        self._call_scheduled()
        self._phase(ACTUATION)
        self._joints.move()

    @property
    def judges(self) -> bool:
        """Return whether scripts process images, or are called on detections."""
        return self._vision.has_work

    def judge_images(self) -> None:
        """Let scripts process the images of their vision sensors, and call them on detections."""
        self._vision.sense()

    @property
    def senses(self) -> bool:
        """Return whether a script may have something to do after the sensors."""
        return self.outside.has(SENSING) or any(map(self._may_sense, self._scripts.called().every))

    def _may_sense(self, script: Script) -> bool:
        if script.interpreter is None:
            return False
        is_lost = script.kind != ScriptKind.MAIN and script.home not in self._sim.scene.objects
        return is_lost or SENSING not in script.interpreter.lacking or bool(script.events or script.changes)

    def sense(self) -> None:
        """Run sensing, after physics and the sensors."""
        self._phase(SENSING)
        self._tell_events()

    def handle_children(self, function: str, *values: Any) -> int:
        """Call a function of all child scripts, for actuation after their threads; return how many have it."""
        return self._call_children(self._scripts.called().children, function, *values)

    def _call_children(self, children: tuple[Script, ...], function: str, *values: Any) -> int:
        if function == ACTUATION and self._resume(children):
            children = self._scripts.called().children  # a thread may have changed them
        return self._call(children, function, *values)

    def handle_child(self, owner: int, function: str, *values: Any) -> int:
        """Call a function of the child script of an object; return 1 if it has it, else 0."""
        script = self._scripts.of(owner, ScriptKind.CHILD)
        return int(script is not None and self._lives.call(script, function, *values) is not None)

    def handle_customizations(self, function: str, *values: Any) -> int:
        """Call a function of all customization scripts, as a main script wishes: the phase does not call them again.
        Return how many have it.
        """
        self._handled.add(function)
        scripts = self._scripts.called().customizations
        if function == ACTUATION:
            self._resume(scripts)
        return self._call(scripts, function, *values)

    def handle_embedded(self, function: str, *values: Any) -> int:
        """Call a function of all scripts but the main script, in the order of the tree; return how many have it."""
        self._handled.add(function)
        scripts = tuple(each for each in self._scripts.called().every if each.kind != ScriptKind.MAIN)
        if function == ACTUATION:
            self._resume(scripts)
        return self._call(scripts, function, *values)

    def call_all(self, function: str, *values: Any) -> None:
        """Call a function of all scripts."""
        self._call(self._scripts.called().every, function, *values)
        self.outside.call(function, *values)

    def call_customizations(self, function: str) -> None:
        """Call a function of all customization scripts."""
        self._call(self._scripts.called().customizations, function)
        self.outside.call(function)

    def _call(self, scripts: tuple[Script, ...], function: str, *values: Any) -> int:
        """Call a function of these scripts; return how many have it."""
        have_it = 0
        for script in scripts:
            if self._lives.call(script, function, *values) is not None:
                have_it += 1
        return have_it

    def _resume(self, scripts: tuple[Script, ...]) -> bool:
        """Resume the threads of these scripts; return whether there are any."""
        have_threads = False
        for script in scripts:
            if script.has_thread:
                have_threads = True
                self._lives.resume(script)
        return have_threads

    def start(self) -> None:
        simulated = [one for one in self._simulated() if one.starts_enabled]
        for script in simulated:
            self._lives.begin(script)
        for script in simulated:
            self._lives.call(script, "sysCall_init")
        self.watch()

    def begin(self, script: Script) -> None:
        """Start a script and call its init."""
        self._lives.begin(script)
        self._lives.call(script, "sysCall_init")

    def _call_scheduled(self) -> None:
        for script in self._scripts.called().every:
            if script.scheduled:
                self._lives.call_scheduled(script, time.monotonic())

    def _phase(self, function: str) -> None:
        scripts = self._scripts.called()
        self._handled.clear()
        if scripts.main:
            self._lives.call(scripts.main[0], function)
        else:
            self._call_children(scripts.children, function)
        if function not in self._handled and self._scripts.called().customizations:
            self.handle_customizations(function)
        self.outside.call(function)

    def stop(self) -> None:
        simulated = self._simulated()
        for script in simulated:
            script.switching.is_last = True
            self._lives.resume(script)
        for script in simulated:
            self._lives.call(script, "sysCall_cleanup")
            self._lives.drop(script)
        self.watch()

    def _simulated(self) -> list[Script]:
        """Return the scripts that run from start to stop."""
        return [one for one in self._scripts.called().every if one.kind != ScriptKind.CUSTOMIZATION]

    @property
    def want_idle(self) -> bool:
        """Return whether a script wants to run while the simulation is stopped or paused."""
        return self._wants_idle or any(map(_SCHEDULED, self._scripts.called().every))

    def idle(self) -> None:
        """Run the scripts while no simulation step is due, if any wants that: the simulation is stopped or paused."""
        if not self.want_idle:
            return
        self._call_scheduled()
        if self._sim.is_running:
            self.call_all("sysCall_suspended")
        else:
            self._resume(self._scripts.called().customizations)
            self.call_customizations("sysCall_nonSimulation")
        self._tell_events()

    def _tell_events(self) -> None:
        """Send waiting events to the scripts, as a list in CBOR."""
        for script in self._scripts.called().every:
            if not (script.events or script.changes) or not script.has(EVENT):
                continue
            events = [*script.events.values(), *(script.changes() if script.changes else ())]
            if script.events:
                script.events.clear()
                self._sim.parts.replan()
            if events:
                self._lives.call(script, EVENT, _LIST + b"".join(events) + _END)

    def watch(self) -> None:
        """Update the lists of call-backs after scripts have started or ended."""
        scripts = self._scripts.called().every
        if not scripts and not self._watched:
            self._watch_idle()
            return
        self._watched = scripts
        self._watch_idle()
        self._guards = [script for script in scripts if script.has(BEFORE)]
        for script in scripts:
            if script.changes is None and script.watch_all is not None and script.has(EVENT):
                script.changes = script.watch_all()
        self._joints.watch(scripts)
        self._vision.watch(scripts)
        self._physics.watch(scripts)
        self.objects.watch(scripts)

    def _watch_idle(self) -> None:
        """Check whether a script wants calls while the simulation is idle; without one there are none."""
        self._wants_idle = self.outside.has(*_IDLE_FUNCTIONS) or any(
            one.has_thread or any(map(one.has, _IDLE_FUNCTIONS)) for one in self._scripts.called().every
        )

    def _outside_changed(self) -> None:
        self._watch_idle()
        self._sim.parts.replan()
