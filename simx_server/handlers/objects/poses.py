"""Where objects are and how fast they move. Frames and conventions: `scene/frames.py`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.handlers.registry import handler
from simx_server.scene.geometry import frames
from simx_server.scene.geometry.poses import Pose

if TYPE_CHECKING:
    from simx_server.world.simulation import Simulation

AXIS_FLAG = 0x400000
"""`sim_handleflag_axis`: added to the handle, the angular velocity is the physical one."""


@handler("simxGetObjectPosition")
def get_object_position(sim: Simulation, handle: int, relative_to: int) -> list[float]:
    return frames.get_position(sim, handle, relative_to)


@handler("simxSetObjectPosition")
def set_object_position(sim: Simulation, handle: int, relative_to: int, position: list[float]) -> None:
    """Children move along; dynamic shapes lose their velocity, or get the first one they were given since.

    A link moves against its joint, which stays; a joint moves with all it carries.
    """
    frames.set_position(sim, handle, relative_to, position)
    _launch(sim, handle)


@handler("simxGetObjectOrientation")
def get_object_orientation(sim: Simulation, handle: int, relative_to: int) -> list[float]:
    return frames.get_orientation(sim, handle, relative_to)


@handler("simxSetObjectOrientation")
def set_object_orientation(sim: Simulation, handle: int, relative_to: int, euler: list[float]) -> None:
    """As simxSetObjectPosition, about the object's own origin."""
    frames.set_orientation(sim, handle, relative_to, euler)
    _launch(sim, handle)


@handler("simxGetObjectQuaternion")
def get_object_quaternion(sim: Simulation, handle: int, relative_to: int) -> list[float]:
    return frames.get_quaternion(sim, handle, relative_to)


@handler("simxSetObjectQuaternion")
def set_object_quaternion(sim: Simulation, handle: int, relative_to: int, quaternion: list[float]) -> None:
    """As simxSetObjectPosition, about the object's own origin."""
    frames.set_quaternion(sim, handle, relative_to, quaternion)
    _launch(sim, handle)


def set_object_pose(sim: Simulation, handle: int, relative_to: int, pose: Pose) -> None:
    """Position and rotation at once, for scripts; the remote API has no such command."""
    frames.set_pose(sim, handle, relative_to, pose)
    _launch(sim, handle)


def reset_dynamic_object(sim: Simulation, handle: int) -> None:
    """As if the physics met the object and all below it for the first time: at rest, or with its first velocity."""
    set_object_pose(sim, handle, frames.WORLD, frames.get_pose(sim, handle))


def _launch(sim: Simulation, handle: int) -> None:
    if sim.is_running:
        placed = handle & ~frames.JOINT_BASE_FLAG
        sim.object_settings.launch([placed, *sim.scene.descendants(placed)])


@handler("simxGetObjectVelocity")
def get_object_velocity(sim: Simulation, handle: int) -> tuple[list[float], list[float]]:
    """Linear m/s and angular rad/s, world axes, over the last pass; Euler rates unless the flag is set.

    Differs: zero when stopped, where V-REP goes on giving the last values of the run.
    """
    flagged = handle > 0 and bool(handle & AXIS_FLAG)
    linear, euler_rates, angular = sim.measured_velocity(handle & ~AXIS_FLAG if flagged else handle)
    return linear, angular if flagged else euler_rates
