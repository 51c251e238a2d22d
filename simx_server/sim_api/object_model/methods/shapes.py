"""Methods of shapes, of their meshes, and of joints."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import rotate
from simx_server.sim_api.object_model.values import Matrix, Ref, to_matrix
from simx_server.sim_api.values.matrices import as_pose

from .method import Call, Options, method, number, numbers, option, pair
from .scene import refs

_RESET_FORCE, _RESET_TORQUE = 0x400000, 0x800000
"""sim.handleflag_resetforce, sim.handleflag_resettorque."""


@method("shape", "ungroup", "changes")
def ungroup(call: Call) -> list[Ref]:
    """Return the shapes of which this compound was made."""
    return refs(call.sim.ungroupShape(call.handle))


@method("shape", "divide", "changes")
def divide(call: Call) -> list[Ref]:
    """Return the parts of this shape that hang together, each a shape now."""
    return refs(call.sim.divideShape(call.handle))


@method("shape", "addForce", "changes")
def add_force(call: Call, force: list[float], options: Options = None) -> None:
    """Add a force (N) at the centre of mass, or at `offset` (m) from it; both along the world's axes, or with
    `relative` along the shape's. `reset`: forces and torques added before are deleted.
    """
    offset = numbers(option(options, "offset", [0.0, 0.0, 0.0]), "offset")
    turn = _turn(call) if option(options, "relative", False) else None
    pushed = _rotated(turn, _vector(force, "a force"))
    lever = np.array(_rotated(turn, _vector(offset, "an offset")))
    torque = np.cross(lever, np.array(pushed)).tolist()
    call.sim.addForceAndTorque(_with_reset(call, options, _RESET_FORCE), pushed, torque)


@method("shape", "addTorque", "changes")
def add_torque(call: Call, torque: list[float], options: Options = None) -> None:
    """Add a torque (N m) along the world's axes; options as of addForce."""
    turn = _turn(call) if option(options, "relative", False) else None
    turned = _rotated(turn, _vector(torque, "a torque"))
    call.sim.addForceAndTorque(_with_reset(call, options, _RESET_TORQUE), None, turned)


def _with_reset(call: Call, options: Options, flag: int) -> int:
    return call.handle | (flag if option(options, "reset", False) else 0)


def _vector(values: list[float], what: str) -> list[float]:
    if len(values) != 3:
        raise CommandError(f"{what} is three numbers, not {len(values)}")
    return values


def _turn(call: Call) -> Any:
    return frames.get_pose(call.world.simulation, call.handle, frames.WORLD)[1]


def _rotated(turn: Any, values: list[float]) -> list[float]:
    return values if turn is None else list(rotate(turn, values))


@method("shape", "computeInertia", "changes")
def compute_inertia(call: Call, density: float) -> None:
    """Compute mass and inertia of this shape filled with this density in kg/m^3."""
    call.sim.computeMassAndInertia(call.handle, density)


@method("shape", "getInertia", "reads")
def get_inertia(call: Call) -> Any:
    """Return the inertia (kg m^2) about the centre of mass, along the shape's axes, and that centre in its frame."""
    moments, frame = call.sim.getShapeInertia(call.handle)
    return Matrix(3, 3, moments), Matrix.vector(frame[3::4])


@method("shape", "setInertia", "changes", takes_values=True)
def set_inertia(call: Call, inertia: Any, pose: Any = None) -> None:
    """Set the inertia (3 x 3) along the axes of a pose in the shape's frame, whose position is the centre of mass."""
    matrix = to_matrix(inertia)
    if (matrix.rows, matrix.columns) not in ((3, 3), (9, 1)):
        raise CommandError(f"an inertia is a matrix of 3 x 3, not {matrix.rows} x {matrix.columns}")
    own = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] if pose is None else to_matrix(pose).numbers
    call.sim.setShapeInertia(call.handle, matrix.numbers, frames.matrix12(as_pose(own)))


@method("shape", "relocateFrame", "changes")
def relocate_frame(call: Call, pose: list[float] | None = None) -> None:
    """Move the frame to a pose in the world, or to the middle of the bounding box; the surface stays."""
    call.sim.relocateShapeFrame(call.handle, [0.0] * 7 if pose is None else pose)


@method("shape", "alignBoundingBox", "changes")
def align_bounding_box(call: Call, quaternion: list[float] | None = None) -> None:
    """Turn the bounding box of a shape: to a direction in the world, or to the smallest box."""
    call.sim.alignShapeBB(call.handle, [0.0, 0.0, 0.0, *(quaternion or [0.0] * 4)])


_COMPONENTS = {"diffuse": 0, "specular": 2, "emission": 3, "transparency": 4}


@method("shape", "getAppearance", "reads")
def get_appearance(call: Call) -> list[dict[str, Any]]:
    """Return the colours of each part, as numbers, for setAppearance."""
    found: dict[str, Any] = {}
    for word, component in _COMPONENTS.items():
        value = call.world.shape_colors.get(call.handle, component)
        if value is not None:
            found[word] = list(value)
    return [{"color": found}]


@method("shape", "setAppearance", "changes")
def set_appearance(call: Call, parts: list[Any]) -> None:
    """Set the colours that getAppearance has returned."""
    first = cast(dict[str, Any], parts[0]) if parts and isinstance(parts[0], dict) else {}
    colors = first.get("color")
    if not isinstance(colors, dict):
        raise CommandError("an appearance is a list of maps with the key color, as getAppearance returns it")
    for word, value in cast(dict[str, Any], colors).items():
        if word not in _COMPONENTS:
            raise CommandError(f"'{str(word)[:40]}' is no colour; those are {', '.join(_COMPONENTS)}")
        call.world.shape_colors.set(call.handle, _COMPONENTS[word], numbers(value, word))


def _texture(call: Call) -> int:
    number = call.sim.getShapeTextureId(call.handle)
    if number == -1:
        raise CommandError("the shape has no texture; texture.set gives it one")
    return number


@method("shape mesh", "texture.getData", "reads")
def get_texture_data(call: Call, options: Options = None) -> Any:
    """Return the pixels, red, green, blue; options `position` and `size` of a part."""
    x, y = pair(options, "position") or [0, 0]
    width, height = pair(options, "size") or [0, 0]
    return call.sim.readTexture(_texture(call), 0, x, y, width, height)


@method("shape mesh", "texture.setData", "changes")
def set_texture_data(call: Call, data: bytes, options: Options = None) -> None:
    """Replace pixels; options `position` and `size` of a part."""
    x, y = pair(options, "position") or [0, 0]
    width, height = pair(options, "size") or [0, 0]
    call.sim.writeTexture(_texture(call), 0, data, x, y, width, height)


@method("shape mesh", "texture.set", "changes")
def set_texture(call: Call, image: bytes, resolution: list[int], options: Options = None) -> None:
    """Apply an image to this shape; options `scalingUV`, metres of a repetition."""
    plane, number, _ = call.sim.createTexture("", 0, None, None, None, 0, resolution)
    try:
        call.sim.writeTexture(number, 0, image)
        scaling = numbers(option(options, "scalingUV", [1.0, 1.0]), "scalingUV")
        call.sim.setShapeTexture(call.handle, number, 0, 0, scaling)
    finally:
        call.sim.removeObjects([plane])


def _motion(options: Options) -> list[float] | None:
    """Return the greatest velocity, acceleration and jerk of the options; 0 leaves one as it is."""
    names = ("maxVelocity", "maxAcceleration", "maxJerk")
    found = [number(options, name, 0.0) for name in names]
    return found if any(found) else None


@method("joint", "setTargetPosition", "changes")
def set_target_position(call: Call, position: float, options: Options = None) -> None:
    """Set the target position; options maxVelocity, maxAcceleration, maxJerk."""
    call.sim.setJointTargetPosition(call.handle, position, _motion(options))


@method("joint", "setTargetVelocity", "changes")
def set_target_velocity(call: Call, velocity: float, options: Options = None) -> None:
    """Set the target velocity; options maxAcceleration, maxJerk."""
    motion = _motion(options)
    call.sim.setJointTargetVelocity(call.handle, velocity, motion and motion[1:])
