"""Call-backs of scripts that control joints.

V-REP calls `sysCall_jointCallback` of a joint's own script, CoppeliaSim since 4.3 `sysCall_joint` of the first script
that answers, from the joint's own one up the tree to the main script:

* in dynamic mode with custom control, before each physics step. The answer has the velocity and the maximum force;
* in kinematic mode, once in each simulation step after a target was set. The answer has the position, the velocity for
  the next call, and whether the joint has arrived.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from simx_client.protocol import constants as c
from simx_server.joints.state import JointState, Request
from simx_server.joints.stepping.scripted import Ask, number
from simx_server.scene.objects import ObjectKind

from ..script import Script, ScriptKind

if TYPE_CHECKING:
    from simx_server.parts.status_bar import StatusBar
    from simx_server.simulation.simulation import Simulation

    from ..lives import Lives

logger = logging.getLogger(__name__)

OLD_CALLBACK = "sysCall_jointCallback"
CALLBACK = "sysCall_joint"

_KINEMATIC, _DYNAMIC = 0, 5
"""`sim.jointmode_kinematic`, `sim.jointmode_dynamic`."""

_NEW_NAMES: Mapping[str, str] = {
    "currentPos": "pos",
    "errorValue": "error",
    "dynStepSize": "dt",
    "maxForce": "force",
    "velUpperLimit": "maxVel",
}
"""Entries of the old call-back whose names changed."""


class JointCallBacks:
    """Asks scripts how joints move."""

    def __init__(self, sim: Simulation, lives: Lives, status_bar: StatusBar) -> None:
        self._sim = sim
        self._lives = lives
        self._status_bar = status_bar
        self._told: set[Script] = set()
        """Scripts for which the warning about their call-back was printed; it is printed once."""
        self._chains: dict[int, list[Script]] = {}
        """Of each joint the scripts with the newer call-back that it reaches, the nearest first."""

    def watch(self, scripts: Sequence[Script]) -> None:
        """Find the joints that scripts control, after scripts have started or ended."""
        asked: dict[int, Ask] = {}
        for script in reversed(scripts):
            is_first = script.kind == ScriptKind.CHILD or script.owner not in asked
            if is_first and script.has(OLD_CALLBACK):
                asked[script.owner] = self._old_asking(script)
                self._tell_of_spring(script)
        self._chains = self._find_chains([script for script in scripts if script.has(CALLBACK)])
        custom = self._chains.keys() - asked.keys()
        asked |= {handle: self._asking(handle, self._chains[handle]) for handle in custom}
        self._sim.joints.ask(asked, custom=custom, kinematic=self._chains.keys())

    def move(self) -> None:
        """Ask scripts where kinematic joints with a target are at the end of this simulation step."""
        if not self._chains:
            return
        joints = self._sim.joints
        for handle, request in joints.requests():
            if handle not in self._sim.scene.objects:  # the call-back for another joint has removed it
                continue
            answer = self._answer(self._chains.get(handle, ()), self._kinematic(handle, request))
            if answer is None or handle not in self._sim.scene.objects:
                continue
            position = number(answer.get("pos"))
            if position is not None:
                joints.set_position(handle, position)
            if not answer.get("immobile", False):
                velocity, acceleration = (number(answer.get(name)) or 0.0 for name in ("vel", "accel"))
                joints.request(handle, request.going_on(velocity, acceleration))

    def _kinematic(self, handle: int, request: Request) -> dict[str, Any]:
        """Return what a script learns about a kinematic joint."""
        joints = self._sim.joints
        state, position = joints.state(handle), joints.position(handle)
        cyclic, least, extent = joints.interval(handle)
        known: dict[str, Any] = {
            "mode": _KINEMATIC,
            "handle": handle,
            "revolute": joints.joint_type(handle) == c.sim_joint_revolute_subtype,
            "cyclic": cyclic,
            "lowLimit": least,
            "highLimit": least + extent,
            "dt": self._sim.time_step,
            "pos": position,
            "vel": request.present_velocity,
            "accel": request.present_acceleration,
            "targetVel": request.velocity,
            **_limits_of_motion(state),
        }
        if request.position is not None:
            error = request.position - position
            known |= {
                "targetPos": request.position,
                "error": math.remainder(error, math.tau) if cyclic else error,
            }
        return known

    def _find_chains(self, askers: Sequence[Script]) -> dict[int, list[Script]]:
        """Return the scripts that each joint's call-back reaches, the nearest first."""
        scene = self._sim.scene
        homes: dict[int, list[Script]] = {}
        for script in sorted(askers, key=lambda one: one.kind != ScriptKind.CHILD):
            homes.setdefault(-1 if script.kind == ScriptKind.MAIN else script.owner, []).append(script)
        chains: dict[int, list[Script]] = {}
        for joint in scene.of_kind(ObjectKind.JOINT) if askers else ():
            chain, handle = list[Script](), joint
            while handle != -1:
                chain += homes.get(handle, ())
                handle = scene.objects[handle].parent
            if chain := [*chain, *homes.get(-1, ())]:
                chains[joint] = chain
        return chains

    def _old_asking(self, script: Script) -> Ask:
        def ask(known: dict[str, Any]) -> Mapping[str, Any] | None:
            with self._sim.physics_calls.calling(OLD_CALLBACK):
                return _table(self._lives.call(script, OLD_CALLBACK, known))

        return ask

    def _asking(self, handle: int, chain: Sequence[Script]) -> Ask:
        def ask(known: dict[str, Any]) -> Mapping[str, Any] | None:
            entries = {_NEW_NAMES.get(name, name): value for name, value in known.items()}
            entries |= {"mode": _DYNAMIC, "rk4pass": 1, **_limits_of_motion(self._sim.joints.state(handle))}
            with self._sim.physics_calls.calling(CALLBACK):
                return self._answer(chain, entries)

        return ask

    def _answer(self, chain: Sequence[Script], entries: Mapping[str, Any]) -> Mapping[str, Any] | None:
        """Return the first answer of the scripts."""
        for script in chain:
            if (found := _table(self._lives.call(script, CALLBACK, dict(entries)))) is not None:
                return found
        return None

    def _tell_of_spring(self, script: Script) -> None:
        if script in self._told or not self._sim.joints.is_spring(script.owner):
            return
        self._told.add(script)
        name = self._sim.scene.get(script.owner).name
        text = (
            f"{OLD_CALLBACK} of the {self._lives.describe(script)} is not called: a spring and damper drives the "
            f"joint, as every plain position actuator does; annotate it with control=position (simx:joint:{name})"
        )
        logger.warning("%s", text)
        self._status_bar.add(text)


def _table(results: Sequence[Any] | None) -> Mapping[str, Any] | None:
    first = results[0] if results else None
    return cast("Mapping[str, Any]", first) if isinstance(first, dict) else None


def _limits_of_motion(state: JointState) -> dict[str, float]:
    return {"maxVel": state.upper_velocity, "maxAccel": state.acceleration, "maxJerk": state.jerk}
