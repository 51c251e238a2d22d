"""Copy the data that the web viewer shows out of the server, on request. Physics thread.

An add-on that is called with simxCallScriptFunction (type 2, name `ADD_ON`). It reads, and makes single steps:

==========  ==========================================  ===========================================================
function    integers                                    answer
==========  ==========================================  ===========================================================
look        known model, known version of its arrays    buffer: `Look`, for each update of the scene
survey      known tree, known drawings                  buffer: `Survey`, for the panels, a few times per second
onePass                                                 starts if necessary, makes one simulation step, pauses
speed       (one float) times real time, or infinity
past        step, known model, known arrays             buffer: `Past`, the world after a step of this run
sensing                                                 buffer: `Sensing`, readings of sensors as lines
files                                                   buffer: `Files`, names of shipped scenes and models
save        (one string) file in the workspace, or ''   buffer: `Saved`; the scene is saved there, or sent
==========  ==========================================  ===========================================================

`simx_client.protocol.add_ons.past` has the functions for past steps that other programs use as well.

Answers are msgpack maps. A field that the caller knows already is None: models are large, and trees rarely change.
"""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeVar

import msgpack
import mujoco

from simx_client.protocol.add_ons import windows
from simx_client.protocol.add_ons.past import GO_ON, KEEP, KEPT, STEP, GoneOn, Kept, PastStep
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.constants import sim_joint_spherical_subtype
from simx_client.protocol.reports import Metrics
from simx_server.errors import CommandError
from simx_server.history import History
from simx_server.history.going_on import go_on
from simx_server.joints.parameters import CONTROL_MODE, get_parameter
from simx_server.parts.add_ons import Functions, Results
from simx_server.parts.drawing import LINES, SPHERES
from simx_server.scene.editing.model_state import get_state
from simx_server.scene.object_listing import list_objects
from simx_server.scene.objects import ObjectKind
from simx_server.service.monitoring import report
from simx_server.simulation.part import Part
from simx_server.simulation.simulation import SimulationState

from .inspection import plot_of, script_views, sensing, shipped_files
from .messages import (
    ADD_ON,
    FILES,
    LOOK,
    ONE_STEP,
    OWN_NAME,
    PAST,
    READS,
    SAVE,
    SENSING,
    SPEED,
    SURVEY,
    Drawing,
    JointView,
    Look,
    Past,
    Saved,
    SceneItem,
    Signals,
    StreamView,
    Survey,
)
from .past import past_call, past_joints, past_signals
from .sent_model import SentModel

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.service.service import Service
    from simx_server.simulation.simulation import Simulation

_MOST_TEXT = 200
"""Bytes of a string signal that are shown."""

_MOST_LETTERS = 2000
"""Letters of a message, or of a line of a console."""

_MOST_LINES = 100
"""Lines of a console or the status bar."""

_MOST_ITEMS = 10_000
"""Items of drawing objects in an answer; a browser does not show more in good time."""
_PATH_WIDTH = 2.0
_PATH_COLOR = (0.1, 0.5, 0.9)

T = TypeVar("T")

_MOST_SIGNALS = 1000
"""Signals of a kind in an answer."""

_METRICS_EVERY = 1.0
"""Seconds. The metrics cover the last five, and with many commands they cost more than all the rest."""


class Feed(Part):
    """The add-on. It sends `realm` and `ports` to the viewer, which shows how to connect."""

    def __init__(
        self, service: Service, realm: str, ports: Sequence[int], history: History | None = None
    ) -> None:
        """Make it; without a history it makes one that is kept while a viewer wants it."""
        self._service = service
        self._world = service.world
        self._sim = service.simulation
        self._realm, self._ports = realm, list(ports)
        if history is None:
            history = History(service)
            service.watchers.add(history)
        self._history = history
        self._history.log.leave_out(_is_of_viewer)
        self._old: SentModel | None = None
        """The model of a past step, while it is not the present one."""

        self._functions = Functions[Callable[..., Mapping[str, Any] | None]](
            ADD_ON,
            {
                LOOK: (2, 0, self._look),
                SURVEY: (2, 0, self._survey),
                ONE_STEP: (0, 0, self._one_step),
                SPEED: (0, 1, self._set_speed),
                PAST: (3, 0, self._past),
                SENSING: (0, 0, lambda: sensing(self._world)),
                FILES: (0, 0, shipped_files),
                SAVE: (0, 0, self._save),
                KEEP: (1, 0, self._keep_past),
                KEPT: (0, 0, self._kept),
                STEP: (1, 0, self._past_step),
                GO_ON: (1, 0, self._go_on),
            },
        )
        self._sent: SentModel | None = None
        """None: the present model was not requested yet."""
        self._metrics: Metrics | None = None
        self._metrics_until = 0.0
        self._pausing_at: int | None = None
        self._sim.parts.attach(self)

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results:
        """Call a function of the add-on. Raises CommandError: unknown function, wrong count of numbers, or refused."""
        if session := self._service.clients.sessions.get(self._service.executor.client):
            session.look_on()
        if function == SAVE:
            return [], [], [], msgpack.packb(self._save(*strings[:1]))
        answer = self._functions.find(function, ints, floats)(*ints, *floats)
        return [], [], [], b"" if answer is None else msgpack.packb(answer)

    # --- the scene -------------------------------------------------------------------------------

    def _look(self, known_model: int, known_arrays: int) -> Look:
        sim = self._sim
        sim.refresh()
        if self._sent is None:
            self._sent = SentModel(sim.model)
        sent = self._sent
        is_new = known_model != sent.number
        version = sim.model_version & 0x7FFFFFFF
        return {
            "model": sent.number,
            "arrays_version": version,
            "binary": sent.binary if is_new else None,
            "arrays": sent.changed_arrays() if is_new or known_arrays != version else None,
            "state": get_state(sim.model, sim.data).tobytes(),
            "running": sim.state.value,
            "time": sim.time,
            "steps": sim.step_count,
            "scene": sim.scene.name,
            "selection": self._selection(),
        }

    def model_changed(self, twins: Twins | None) -> None:
        self._old, self._sent = self._sent, None

    def _selection(self) -> list[int]:
        return [handle for handle in self._world.selection.handles if handle in self._sim.scene.objects]

    # --- the past --------------------------------------------------------------------------------

    def _keep_past(self, wanted: int) -> None:
        self._history.want(self._service.executor.client, bool(wanted))

    def _past(self, step: int, known_model: int, known_arrays: int) -> Past:
        """Return the world after a kept step, or after the last kept one before it."""
        sim, history = self._sim, self._history
        step = history.nearest(step)
        moment = history.moment(step)
        sent = self._sent_of(moment.model)
        version = moment.structure.version & 0x7FFFFFFF
        is_new = known_model != sent.number
        is_news = is_new or known_arrays != version
        look: Look = {
            "model": sent.number,
            "arrays_version": version,
            "binary": sent.binary if is_new else None,
            "arrays": sent.differences(moment.structure.snapshot.arrays) if is_news else None,
            "state": moment.state.tobytes(),
            "running": "running",
            "time": step * sim.time_step,
            "steps": step,
            "scene": sim.scene.name,
            "selection": self._selection(),
        }
        return {"look": look, "step": self._past_step(step)}

    def _past_step(self, step: int) -> PastStep:
        """Return what belongs to a kept step, or to the last kept one before it."""
        history = self._history
        step = history.nearest(step)
        moment, calls = history.moment(step), history.calls(step)
        return {
            "step": step,
            "time": step * self._sim.time_step,
            "calls": [past_call(called) for called in calls.calls],
            "calls_left_out": calls.left_out,
            "call_before": history.find_change(step, -1),
            "call_after": history.find_change(step, +1),
            "signals": past_signals(moment.signals),
            "joints": past_joints(moment),
        }

    def _sent_of(self, model: mujoco.MjModel) -> SentModel:
        """Return the model of a past step as it was sent, or is going to be."""
        for sent in (self._sent, self._old):
            if sent is not None and sent.model is model:
                return sent
        sent = SentModel(model)
        if model is self._sim.model:
            self._sent = sent
        else:
            self._old = sent
        return sent

    def _go_on(self, step: int) -> GoneOn:
        gone = go_on(self._service, self._history, step)
        return {"step": gone.step, "time": gone.time, "restarted": gone.restarted}

    def _kept(self) -> Kept:
        history = self._history
        first, last = history.steps or (-1, -1)
        return {
            "now": (self._sim.state.value, self._sim.time, self._sim.step_count),
            "is_on": history.is_kept,
            "first": first,
            "last": last,
            "version": history.version,
            "time_step": self._sim.time_step,
            "seconds": history.seconds,
            "size": history.size,
        }

    # --- the panels ------------------------------------------------------------------------------

    def _survey(self, known_tree: int, known_drawings: int) -> Survey:
        sim, service = self._sim, self._service
        tree = self._tree_version()
        drawings = (self._world.drawings.version + self._world.paths.version) & 0x7FFFFFFF
        is_carried = self._world.drawings.are_carried or bool(self._world.paths.handles())
        is_carried = is_carried or self._world.particles.has_work
        is_drawn_anew = drawings != known_drawings or is_carried
        pace = self._world.parameters.pace
        return {
            "tree_version": tree,
            "tree": _tree(sim) if tree != known_tree else None,
            "drawings_version": drawings,
            "drawings": self._drawings() if is_drawn_anew else None,
            "joints": self._joints(),
            "signals": self._signals(),
            "interface": self._interface(),
            "messages": self._world.status_bar.count,
            "speed": None if pace is None else pace.speed,
            "time_step": sim.time_step,
            "steppers": [one.name for one in service.clients.sessions.values() if one.is_stepping],
            "is_waiting": service.due.is_waiting_for_trigger,
            "metrics": self._recent_metrics(),
            "streams": self._streams(),
            "past": self._kept(),
            "scripts": script_views(self._world),
            "workspace": str(sim.files.workspace),
        }

    def _recent_metrics(self) -> Metrics:
        now = time.monotonic()
        if self._metrics is None or now >= self._metrics_until:
            self._metrics = report.metrics(self._service, self._realm, self._ports)
            self._metrics_until = now + _METRICS_EVERY
        return self._metrics

    def _tree_version(self) -> int:
        """Return a checksum that changes with everything that the tree shows."""
        shown = [
            (item.handle, item.name, item.alias, item.parent, item.id)
            for item in self._sim.scene.objects.values()
        ]
        return zlib.crc32(repr((self._sim.scene_id, shown)).encode()) & 0x7FFFFFFF

    def _joints(self) -> dict[int, JointView]:
        joints = self._sim.joints
        found: dict[int, JointView] = {}
        for handle in self._sim.scene.of_kind(ObjectKind.JOINT):
            cyclic, minimum, extent = joints.interval(handle)
            is_ball = joints.joint_type(handle) == sim_joint_spherical_subtype
            found[handle] = {
                "position": None if is_ball else joints.position(handle),
                "target": None if is_ball else joints.target_position(handle),
                "mode": int(joints.mode(handle)),
                "moved_by": joints.rule(handle).name,
                "control": -1 if is_ball else int(get_parameter(joints, handle, CONTROL_MODE)),
                "target_velocity": 0.0 if is_ball else joints.target_velocity(handle),
                "cyclic": cyclic,
                "minimum": minimum,
                "range": extent,
            }
        return found

    def _signals(self) -> Signals:
        signals = self._world.signals
        return {
            "integers": _some(signals.integers),
            "floats": _some(signals.floats),
            "strings": {
                name: {"size": len(value), "beginning": value[:_MOST_TEXT]}
                for name, value in _some(signals.strings).items()
            },
            "count": len(signals.integers) + len(signals.floats) + len(signals.strings),
        }

    def _interface(self) -> dict[str, Any]:
        """Return what programs show; of growing texts, the end."""
        shown = self._world.user_interface.view()
        shown["status_bar"] = [text[:_MOST_LETTERS] for text in shown["status_bar"][-_MOST_LINES:]]
        for console in shown["consoles"]:
            console["lines"] = [line[:_MOST_LETTERS] for line in console["lines"][-_MOST_LINES:]]
        for view in shown["views"]["floating"]:
            if view["kind"] == ObjectKind.GRAPH:
                view["plot"] = plot_of(self._world.graphs.get(view["shown"])).view()
        return shown

    def _streams(self) -> list[StreamView]:
        return [
            {
                "client": session.name,
                "command": stream.command.name,
                "arguments": ", ".join(map(_short, stream.arguments)),
            }
            for session in self._service.clients.sessions.values()
            for stream in session.streams.by_id.values()
        ]

    def _drawings(self) -> list[Drawing]:
        drawn_by_scripts: list[Drawing] = [
            {
                "handle": drawn.handle,
                "flags": drawn.flags,
                "size": drawn.size,
                "color": drawn.color,
                "points": drawn.layout.points,
                "items": items,
            }
            for drawn, items in self._world.drawings.shown(_MOST_ITEMS)
        ]
        # Handles of paths are those of objects; below 0 no drawing object has them.
        paths: list[Drawing] = [
            {
                "handle": -handle,
                "flags": LINES,
                "size": _PATH_WIDTH,
                "color": _PATH_COLOR,
                "points": 2,
                "items": items,
            }
            for handle, items in self._world.paths.lines(_MOST_ITEMS)
        ]
        # Above 2^30 no object and no drawing object has a handle.
        particles: list[Drawing] = [
            {
                "handle": (1 << 30) + handle,
                "flags": SPHERES,
                "size": float(each.sizes.mean()),
                "color": each.color,
                "points": 1,
                "items": each.places.tolist(),
            }
            for handle, each in self._world.particles.shown(_MOST_ITEMS)
        ]
        return drawn_by_scripts + paths + particles

    # --- one step --------------------------------------------------------------------------------

    def _one_step(self) -> None:
        sim = self._sim
        if sim.state is SimulationState.RUNNING:
            if self._service.due.is_waiting_for_trigger:
                raise CommandError(
                    "a client steps the simulation, so passes come when it asks; end its stepped mode first"
                )
            sim.pause()
            return
        sim.start()
        self._pausing_at = sim.step_count + 1

    def step_finished(self) -> None:
        if self._pausing_at is not None and self._sim.step_count >= self._pausing_at:
            self._pausing_at = None
            self._sim.pause()

    def awaits_steps(self) -> bool:
        return self._pausing_at is not None

    def run_stopped(self) -> None:
        self._pausing_at = None

    def _save(self, file: str = "") -> Saved:
        from simx_server.handlers.scene_files import saving  # large, and seldom needed

        if not file:
            return {"file": "", "content": saving.scene_content(self._world).data}
        saving.save_scene(self._world, file)
        return {"file": saving.saved_name(self._world, file), "content": b""}

    def _set_speed(self, speed: float) -> None:
        pace = self._world.parameters.pace
        if pace is None or not speed > 0:
            raise CommandError(
                f"a speed is a number above 0, or infinity for as fast as it goes; not {speed}"
            )
        pace.speed = speed


def _is_of_viewer(client: str, function: str, arguments: Sequence[Any]) -> bool:
    """Return whether a call is one with which the web viewer only reads, or of a window of a script."""
    if function == "simxCallScriptFunction" and len(arguments) > 2:
        add_on, function = arguments[0], arguments[2]
        return (add_on == ADD_ON and function in READS) or (
            add_on == windows.ADD_ON and function in (windows.SHOWN, windows.EXCHANGE)
        )
    command = BY_NAME.get(function)
    return client.startswith(OWN_NAME) and command is not None and command.only_reads


def _some(signals: Mapping[str, T]) -> dict[str, T]:
    return dict(islice(signals.items(), _MOST_SIGNALS))


def _tree(sim: Simulation) -> list[SceneItem]:
    """Return the objects as ``--tree --json`` does, with the model element of each."""
    objects = sim.scene.objects
    return [
        {  # pyright: ignore[reportReturnType]: the listing's own form is that of --tree
            "joint": "",
            "resolution": [],
            **each,
            "element": objects[each["handle"]].element,
            "id": int(objects[each["handle"]].id),
        }
        for each in list_objects(sim)
    ]


def _short(argument: object) -> str:
    text = repr(argument)
    return text if len(text) <= 40 else text[:37] + "..."
