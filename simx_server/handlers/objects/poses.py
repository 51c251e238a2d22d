"""Where objects are and how fast they move. Frames and conventions: `scene/frames.py`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.handlers.registry import handler
from simx_server.scene.geometry import frames
from simx_server.scene.geometry.poses import Pose

if TYPE_CHECKING:
    from simx_server.world.world import World

AXIS_FLAG = 0x400000
"""`sim_handleflag_axis`: added to the handle, the angular velocity is the physical one."""


@handler("simxGetObjectPosition")
def get_object_position(world: World, handle: int, relative_to: int) -> list[float]:
    sim = world.simulation
    return frames.get_position(sim, handle, relative_to)


@handler("simxSetObjectPosition")
def set_object_position(world: World, handle: int, relative_to: int, position: list[float]) -> None:
    """Children move along; dynamic shapes lose their velocity, or get the first one they were given since.

    A link moves against its joint, which stays; a joint moves with all it carries.
    """
    sim = world.simulation
    frames.set_position(sim, handle, relative_to, position)
    _launch(world, handle)


@handler("simxGetObjectOrientation")
def get_object_orientation(world: World, handle: int, relative_to: int) -> list[float]:
    sim = world.simulation
    return frames.get_orientation(sim, handle, relative_to)


@handler("simxSetObjectOrientation")
def set_object_orientation(world: World, handle: int, relative_to: int, euler: list[float]) -> None:
    """As simxSetObjectPosition, about the object's own origin."""
    sim = world.simulation
    frames.set_orientation(sim, handle, relative_to, euler)
    _launch(world, handle)


@handler("simxGetObjectQuaternion")
def get_object_quaternion(world: World, handle: int, relative_to: int) -> list[float]:
    sim = world.simulation
    return frames.get_quaternion(sim, handle, relative_to)


@handler("simxSetObjectQuaternion")
def set_object_quaternion(world: World, handle: int, relative_to: int, quaternion: list[float]) -> None:
    """As simxSetObjectPosition, about the object's own origin."""
    sim = world.simulation
    frames.set_quaternion(sim, handle, relative_to, quaternion)
    _launch(world, handle)


def set_object_pose(world: World, handle: int, relative_to: int, pose: Pose) -> None:
    """Position and rotation at once, for scripts; the remote API has no such command."""
    sim = world.simulation
    frames.set_pose(sim, handle, relative_to, pose)
    _launch(world, handle)


def reset_dynamic_object(world: World, handle: int) -> None:
    """As if the physics met the object and all below it for the first time: at rest, or with its first velocity."""
    sim = world.simulation
    set_object_pose(world, handle, frames.WORLD, frames.get_pose(sim, handle))


def _launch(world: World, handle: int) -> None:
    sim = world.simulation
    if sim.is_running:
        placed = handle & ~frames.JOINT_BASE_FLAG
        world.object_settings.launch([placed, *sim.scene.descendants(placed)])


@handler("simxGetObjectVelocity")
def get_object_velocity(world: World, handle: int) -> tuple[list[float], list[float]]:
    """Linear m/s and angular rad/s, world axes, over the last pass; Euler rates unless the flag is set.

    Differs: zero when stopped, where V-REP goes on giving the last values of the run.
    """
    flagged = handle > 0 and bool(handle & AXIS_FLAG)
    linear, euler_rates, angular = world.velocities.measure(handle & ~AXIS_FLAG if flagged else handle)
    return linear, angular if flagged else euler_rates
