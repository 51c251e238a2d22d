"""V-REP 3's plug-in RosBridge, which drives objects that scripts mark by numbers under headers.

Source of the names and numbers: CustomDataHeaders of the repository lagadic/vrep_ros_bridge.
"""

from __future__ import annotations

import struct
from types import MappingProxyType

from simx_server.errors import CommandError
from simx_server.parts.custom_data import HIDDEN
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.constant_tables.counting import counted

_HEADERS = HIDDEN + "ros_bridge/"
"""Prefix of the names under which the numbers of an object are stored, per header."""

_NOTE = "marks of objects for ROS are kept, and nothing drives the objects: the server has no ROS bridge"

_SPACE = "ext_ros_bridge"


class RosBridgeFunctions(ApiPart):
    """Functions of V-REP 3's plug-in RosBridge: they keep the marks of objects."""

    CONSTANTS = MappingProxyType(
        {
            **counted(
                f"{_SPACE}_quadrotor",
                "data_motor_0 data_motor_1 data_motor_2 data_motor_3 data_main=10 data_com data_tf_ratio "
                "data_ctrl_mode tk_data_main=20 ctrl_mode_direct=0 ctrl_mode_internal",
            ),
            **counted(f"{_SPACE}_imu_data", "main mass force freq cutoff", 200),
            **counted(f"{_SPACE}_camera_data", "main freq rgb has_depth use_float", 300),
            **counted(f"{_SPACE}_manipulator_data", "main freq joint ctrl_mode", 600),
            **counted(
                f"{_SPACE}_manipulator_ctrl_mode",
                "TF_position TF_velocity TF_effort MOT_velocity Passive_mode Passive_mode_velocity Ignore_mode=20",
            ),
            f"{_SPACE}_developer_data_header": 769710397,
            f"{_SPACE}_force_sensor_data_main": 250,
            f"{_SPACE}_obj_pose_data_main": 400,
            f"{_SPACE}_obj_twist_data_main": 500,
            f"{_SPACE}_contact_data_main": 650,
        }
    )

    def extSetFloatCustomDataFromHeader(self, handle: int, header: int, value: float) -> None:
        """Store a number with an object under a header. Stand-in: no ROS bridge reads it."""
        self._put(handle, header, "f", [value])

    def extSetFloatArrayCustomDataFromHeader(self, handle: int, header: int, values: list[float]) -> None:
        """Store numbers with an object under a header. Stand-in: no ROS bridge reads them."""
        self._put(handle, header, "f", values)

    def extSetIntCustomDataFromHeader(self, handle: int, header: int, value: int) -> None:
        """Store an integer with an object under a header. Stand-in: no ROS bridge reads it."""
        self._put(handle, header, "i", [value])

    def extGetCustomDataFromHeader(self, handle: int, header: int) -> float | int | None:
        """Return the number, or the last one, that was stored with an object under a header; nil for none."""
        found = self._world.custom_data.read(self._self(handle), f"{_HEADERS}{header}")
        if not found:
            return None
        letter = found[:1].decode()
        return struct.unpack(f"<{letter}", found[-struct.calcsize(letter) :])[0]

    def _put(self, handle: int, header: int, letter: str, values: list[float]) -> None:
        self._say_once(_NOTE)
        try:
            packed = struct.pack(f"<{len(values)}{letter}", *values)
        except OverflowError:
            raise CommandError(f"{values} are too large for numbers of single precision") from None
        data = letter.encode() + packed if values else b""
        self._world.custom_data.write(self._self(handle), f"{_HEADERS}{header}", data)
