"""The add-on by which clients teleoperate an arm: see `simx_client.protocol.add_ons.teleoperation`. Physics thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import msgpack

from simx_client.protocol.add_ons.teleoperation import ADD_ON, ARMS, DRIVE, GRIPPER, REACH, RELEASE, Arms
from simx_server.errors import CommandError
from simx_server.parts.add_ons import Functions, Results
from simx_server.scene.poses.placing import object_pose

from .arm_drive import ArmDrive
from .arms import Arm, arm_of, find_tips
from .grippers import Gripper, gripper_of

if TYPE_CHECKING:
    from simx_server.kinematics import IkGroups
    from simx_server.parts.communication.signals import Signals
    from simx_server.scripting.scripts import Scripts
    from simx_server.simulation.simulation import Simulation

_Function = Callable[[list[int], list[float], str], bytes]


class TeleoperationAddOn:
    """Call functions by name; the string is the name of an arm."""

    def __init__(
        self, sim: Simulation, groups: IkGroups, signals: Signals, scripts: Scripts, drive: ArmDrive
    ) -> None:
        self._sim, self._groups, self._signals, self._scripts = sim, groups, signals, scripts
        self._drive = drive
        self._grippers: dict[tuple[int, int], Gripper] = {}
        """By scene and tip."""

        self._functions = Functions[_Function](
            ADD_ON,
            {
                DRIVE: (0, 6, self._drive_tip),
                REACH: (0, 7, self._reach),
                GRIPPER: (1, 0, self._move_gripper),
                RELEASE: (0, 0, self._release),
                ARMS: (0, 0, self._arms),
            },
        )

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results:
        """Call a function. Raises CommandError: no such function or arm, or other numbers."""
        found = self._functions.find(function, ints, floats)
        return [], [], [], found(ints, floats, strings[0] if strings else "")

    def _drive_tip(self, _: list[int], floats: list[float], name: str) -> bytes:
        x, y, z, a, b, c = floats
        self._drive.drive(name, (x, y, z, a, b, c))
        return b""

    def _reach(self, _: list[int], floats: list[float], name: str) -> bytes:
        x, y, z, qx, qy, qz, qw = floats
        self._drive.reach(name, ((x, y, z), (qw, qx, qy, qz)))
        return b""

    def _move_gripper(self, ints: list[int], _: list[float], name: str) -> bytes:
        arm = self._arm(name)
        self._gripper(arm).move(self._sim, self._signals, is_open=bool(ints[0]))
        return b""

    def _release(self, *_: object) -> bytes:
        self._drive.release()
        return b""

    def _arms(self, _ints: list[int], _floats: list[float], name: str) -> bytes:
        scene = self._sim.scene
        tips = find_tips(self._sim, self._groups)
        answer: Arms = {
            "names": [scene.get(tip).name for tip in tips],
            "tip": "",
            "problem": self._drive.problem,
            "gripper": "",
            "is_open": True,
            "position": [0.0, 0.0, 0.0],
            "quaternion": [0.0, 0.0, 0.0, 1.0],
            "base": [0.0, 0.0, 0.0, 1.0],
            "is_driven": self._drive.has_work,
        }
        try:
            arm = self._arm(name)
        except CommandError as problem:
            answer["problem"] = str(problem)
        else:
            position, quaternion = self._drive.tip_pose(arm)
            answer["tip"] = scene.get(arm.tip).name
            gripper = self._gripper(arm)
            answer["gripper"] = gripper.name(self._sim)
            answer["is_open"] = gripper.is_open(self._sim, self._signals)
            answer["position"], answer["quaternion"] = list(position), _xyzw(quaternion)
            base = scene.get(arm.joints.handles[0]).parent
            if base != -1:
                answer["base"] = _xyzw(object_pose(self._sim, scene.get(base))[1])
        return msgpack.packb(answer)

    def _arm(self, name: str) -> Arm:
        return arm_of(self._sim, self._drive.tip(name))

    def _gripper(self, arm: Arm) -> Gripper:
        key = self._sim.scene_id, arm.tip
        if key not in self._grippers:
            self._grippers = {key: gripper_of(self._sim, self._scripts, arm)}
        return self._grippers[key]


def _xyzw(quaternion: tuple[float, float, float, float]) -> list[float]:
    w, x, y, z = quaternion
    return [x, y, z, w]
