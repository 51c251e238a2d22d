"""Poses and velocities of objects. Frames and conventions: `scene/poses/frames.py`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.editing.shape_properties import is_static
from simx_server.scene.poses import frames, placing
from simx_server.scene.poses.poses import Pose
from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.world.world import World

AXIS_FLAG = 0x400000
"""`sim_handleflag_axis`: added to the handle, it selects the physical angular velocity."""


@handler("simxGetObjectPosition")
def get_object_position(world: World, handle: int, relative_to: int) -> list[float]:
    return frames.get_position(world.simulation, handle, relative_to)


@handler("simxSetObjectPosition")
def set_object_position(world: World, handle: int, relative_to: int, position: list[float]) -> None:
    """Move the objects below along.

    Dynamic shapes lose their velocity, or get the first velocity that was set since. A link moves relative to its
    joint, which stays; a joint moves with everything below it.
    """
    frames.set_position(world.simulation, handle, relative_to, position)
    _launch(world, handle)


@handler("simxGetObjectOrientation")
def get_object_orientation(world: World, handle: int, relative_to: int) -> list[float]:
    return frames.get_orientation(world.simulation, handle, relative_to)


@handler("simxSetObjectOrientation")
def set_object_orientation(world: World, handle: int, relative_to: int, euler: list[float]) -> None:
    """Turn the object about its own origin, with the same rules as simxSetObjectPosition."""
    frames.set_orientation(world.simulation, handle, relative_to, euler)
    _launch(world, handle)


@handler("simxGetObjectQuaternion")
def get_object_quaternion(world: World, handle: int, relative_to: int) -> list[float]:
    return frames.get_quaternion(world.simulation, handle, relative_to)


@handler("simxSetObjectQuaternion")
def set_object_quaternion(world: World, handle: int, relative_to: int, quaternion: list[float]) -> None:
    """Turn the object about its own origin, with the same rules as simxSetObjectPosition."""
    frames.set_quaternion(world.simulation, handle, relative_to, quaternion)
    _launch(world, handle)


def set_object_pose(world: World, handle: int, relative_to: int, pose: Pose) -> None:
    """Set position and rotation at once, for scripts; the remote API has no such command."""
    frames.set_pose(world.simulation, handle, relative_to, pose)
    _launch(world, handle)


def reset_dynamic_object(world: World, handle: int) -> None:
    """Reset the object and all below it as at the start of physics: at rest, or with the first velocity.

    Static shapes of it that a program moves before the next simulation step drag nothing on their ways.
    """
    sim = world.simulation
    if sim.waiting is not None and handle in sim.waiting.handles:
        sim.waiting.call(lambda: reset_dynamic_object(world, handle))
        return
    placing.rest(sim, sim.scene.get(handle))
    world.surfaces.put([handle, *sim.scene.descendants(handle)])
    _launch(world, handle)


def _launch(world: World, handle: int) -> None:
    sim = world.simulation
    if sim.is_running:
        placed = handle & ~frames.JOINT_BASE_FLAG
        if sim.waiting is not None and placed in sim.waiting.handles:
            sim.waiting.call(lambda: _launch(world, placed))
            return
        world.object_settings.launch([placed, *sim.scene.descendants(placed)])


@handler("simxGetObjectVelocity")
def get_object_velocity(world: World, handle: int) -> tuple[list[float], list[float]]:
    """Return linear m/s and angular rad/s.

    Differs: zero when stopped, where V-REP keeps returning the last values of the run.
    """
    flagged = handle > 0 and bool(handle & AXIS_FLAG)
    linear, euler_rates, angular = world.velocities.measure(handle & ~AXIS_FLAG if flagged else handle)
    return linear, angular if flagged else euler_rates


def get_velocity(world: World, shape: int) -> tuple[list[float], list[float]]:
    """Return the velocity of a shape's centre of mass (m/s) and its angular velocity (rad/s), in world axes.

    They are physics' own, at the end of the last step; those of a static shape are measured from its poses.
    """
    if is_static(world.simulation, shape):
        linear, _, angular = world.velocities.measure(shape)
        return linear, angular
    return world.velocities.of_mass_centre(world.simulation.scene.get(shape).body)
