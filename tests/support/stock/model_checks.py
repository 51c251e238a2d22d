"""Questions about shipped models: is it V-REP's stock model by name, kind, place and data; does a second one load;
does it stand still; how fast is it.

A stock model is a tuple of `Stock`, one for each object, in world axes with the model standing at x = y = 0.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from real_world import BLOCKING, RealWorld, handle_of, step

import simx_client as v
from simx_server.scene.objects import ObjectKind
from simx_server.sensors.proximity.volume import TYPES

Vector = tuple[float, float, float]

SHAPE, DUMMY = "shape", "dummy"
REVOLUTE, PRISMATIC, SPHERICAL = "revolute", "prismatic", "spherical"
RAY, CONE, CYLINDER, PYRAMID, DISC = "ray", "cone", "cylinder", "pyramid", "disc"
VISION, CAMERA, FORCE, LIGHT = "vision", "camera", "force", "light"

_JOINTS = {
    REVOLUTE: v.sim_joint_revolute_subtype,
    PRISMATIC: v.sim_joint_prismatic_subtype,
    SPHERICAL: v.sim_joint_spherical_subtype,
}
_KINDS = {
    SHAPE: ObjectKind.SHAPE,
    DUMMY: ObjectKind.DUMMY,
    VISION: ObjectKind.VISION_SENSOR,
    CAMERA: ObjectKind.CAMERA,
    FORCE: ObjectKind.FORCE_SENSOR,
    LIGHT: ObjectKind.LIGHT,
} | dict.fromkeys(_JOINTS, ObjectKind.JOINT)

NEAR_ENOUGH = 0.001
"""Metres; the tables have four decimals."""
STRAIGHT_ENOUGH = math.radians(0.5)
UNSTIRRED = 0.001 / 60
"""Metres and radians that something may creep by in a second: a millimetre in a minute."""


@dataclass(frozen=True)
class Stock:
    """One object as the stock model has it; what is None is not asked.

    Attributes:
        kind: one of the words above.
        position: world, metres.
        axis: the object's z in the world: a joint's axis, a sensor's view direction.
        up: the object's y in the world.
        euler_deg: V-REP's alpha, beta, gamma of the object in the world.
        mass: kg.
        interval: a joint's least and greatest value; "cyclic" without limits.
        mode: a `sim_jointmode_*` number.
        position_q: what simxGetJointPosition says at the start, rad or m.
        max_force, upper_velocity: of a joint, N or N m, and per second.
        reach, offset: of a proximity sensor's volume, metres.
        angle_deg: a cone's full angle, or the perspective angle of a vision sensor.
        resolution, near, far, ortho: of a vision sensor, pixels and metres.
        explicit: whether a sensor is handled explicitly.
    """

    name: str
    kind: str
    position: Vector | None = None
    axis: Vector | None = None
    up: Vector | None = None
    euler_deg: Vector | None = None
    mass: float | None = None
    interval: tuple[float, float] | str | None = None
    mode: int | None = None
    position_q: float | None = None
    max_force: float | None = None
    upper_velocity: float | None = None
    reach: float | None = None
    offset: float | None = None
    angle_deg: float | None = None
    resolution: tuple[int, int] | None = None
    near: float | None = None
    far: float | None = None
    ortho: float | None = None
    explicit: bool | None = None


def check_stock(
    world: RealWorld,
    client: int,
    rows: Iterable[Stock],
    *,
    suffix: str = "",
    shift: Sequence[float] = (0, 0, 0),
) -> None:
    """Every row is there as it says; all that is not so is told at once.

    Args:
        suffix: of a copy's names, as "#0".
        shift: how far the model stands from where the rows have it, metres, world.
    """
    wrong: list[str] = []
    for row in rows:
        code, handle = v.simxGetObjectHandle(client, row.name + suffix, BLOCKING)
        if code != v.simx_return_ok:
            wrong.append(f"{row.name}{suffix}: there is no such object")
            continue
        wrong += [f"{row.name}{suffix}: {text}" for text in _differences(world, client, row, handle, shift)]
    assert not wrong, "\n".join(wrong)


def load_model(client: int, file: str, at: tuple[float, float]) -> int:
    """Load a model by its stock file name and put its base at `at`, on the height it has; the base's handle."""
    code, base = v.simxLoadModel(client, file, 0, BLOCKING)
    assert code == v.simx_return_ok, v.simxGetLastErrors(client, BLOCKING)
    height = position_of(client, base)[2]
    assert v.simxSetObjectPosition(client, base, -1, [*at, height], BLOCKING) == v.simx_return_ok
    return base


def check_copies(
    world: RealWorld, client: int, file: str, rows: Sequence[Stock], at: tuple[float, float] = (1.0, 1.5)
) -> None:
    """A model, and a second one that is loaded beside it at `at`, are as the rows say."""
    load_model(client, file, (0.0, 0.0))
    load_model(client, file, at)
    check_stock(world, client, rows)
    check_stock(world, client, rows, suffix="#0", shift=(*at, 0.0))


def check_idle(client: int, names: Iterable[str], seconds: float = 10.0, settling: float = 1.0) -> None:
    """Named objects of a stepped, running simulation stay where they are, once they had time to settle."""
    handles = {name: handle_of(client, name) for name in names}
    step(client, settling)
    before = {name: _pose(client, handle) for name, handle in handles.items()}
    step(client, seconds - settling)
    most = UNSTIRRED * (seconds - settling)
    for name, handle in handles.items():
        position, rotation = _pose(client, handle)
        first_position, first_rotation = before[name]
        assert np.all(np.isfinite(position)), name
        assert np.linalg.norm(position - first_position) < most, (name, position - first_position)
        assert _angle(rotation, first_rotation) < most, name


def position_of(client: int, handle: int, relative_to: int = -1) -> list[float]:
    """Metres."""
    code, position = v.simxGetObjectPosition(client, handle, relative_to, BLOCKING)
    assert code == v.simx_return_ok
    return position


def rotation_of(client: int, handle: int) -> np.ndarray:
    """(3, 3): columns are the object's axes in the world."""
    code, (x, y, z, w) = v.simxGetObjectQuaternion(client, handle, -1, BLOCKING)
    assert code == v.simx_return_ok
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def _pose(client: int, handle: int) -> tuple[np.ndarray, np.ndarray]:
    return np.array(position_of(client, handle)), rotation_of(client, handle)


def _differences(
    world: RealWorld, client: int, row: Stock, handle: int, shift: Sequence[float]
) -> Iterable[str]:
    simulation = world.simulation
    item = simulation.scene.get(handle)
    kind = _KINDS.get(row.kind, ObjectKind.PROXIMITY_SENSOR)
    if item.kind != kind:
        yield f"is a {item.kind.text}, not a {kind.text}"
        return
    position, rotation = _pose(client, handle)
    if row.position is not None:
        error = position - np.array(row.position) - np.array(shift)
        if np.linalg.norm(error) > NEAR_ENOUGH:
            yield f"is {np.round(error * 1000, 1).tolist()} mm off"
    for what, column, direction in (("z", 2, row.axis), ("y", 1, row.up)):
        if direction is not None:
            wanted = np.array(direction) / np.linalg.norm(direction)
            # The arc cosine of single precision numbers near 1 has errors of 0.02 degrees.
            turned = 2 * math.asin(min(1.0, float(np.linalg.norm(rotation[:, column] - wanted)) / 2))
            if turned > STRAIGHT_ENOUGH:
                yield f"its {what} is {np.round(rotation[:, column], 3).tolist()}, {math.degrees(turned):.2f} deg off"
    if row.euler_deg is not None:
        turned = _angle(rotation, _from_euler(row.euler_deg))
        if turned > STRAIGHT_ENOUGH:
            yield f"is turned {math.degrees(turned):.2f} deg off"
    yield from _of_kind(world, row, handle)


def _of_kind(world: RealWorld, row: Stock, handle: int) -> Iterable[str]:
    simulation = world.simulation
    item = simulation.scene.get(handle)
    found: dict[str, object] = {}
    if row.kind in _JOINTS:
        joints = simulation.joints
        if joints.joint_type(handle) != _JOINTS[row.kind]:
            yield f"is a joint of type {joints.joint_type(handle)}, not {row.kind}"
            return
        if row.kind != SPHERICAL:
            cyclic, least, extent = joints.interval(handle)
            state = joints.state(handle)
            found = {
                "interval": "cyclic" if cyclic else (least, least + extent),
                "position_q": joints.position(handle),
                "max_force": joints.max_force(handle),
                "upper_velocity": state.upper_velocity,
            }
        found["mode"] = int(joints.mode(handle))
    elif row.kind == VISION:
        settings = world.parts.vision.settings(handle)
        found = {
            "resolution": (settings.width, settings.height),
            "near": settings.near,
            "far": settings.far,
            "explicit": settings.explicit,
            "ortho": settings.orthographic_size,
            "angle_deg": math.degrees(settings.angle),
        }
    elif item.kind == ObjectKind.PROXIMITY_SENSOR:
        if world.parts.proximity.volume_type(handle) != TYPES[row.kind]:
            yield f"is no {row.kind}"
        note = item.annotations.get("proximity", {})
        found = {
            "reach": note.get("range"),
            "offset": note.get("offset", 0.0),
            "angle_deg": note.get("angle_deg"),
            "explicit": note.get("explicit", False),
        }
    elif row.kind == SHAPE:
        found = {"mass": float(simulation.model.body_mass[item.body]) if item.element == "body" else 0.0}
    for name, value in found.items():
        wanted = getattr(row, name)
        if wanted is not None and not _alike(value, wanted):
            yield f"{name} is {value}, not {wanted}"


def _alike(value: object, wanted: object) -> bool:
    """Equal, numbers to the three digits that the tables have."""
    if isinstance(value, str | bool) or isinstance(wanted, str | bool) or value is None:
        return value == wanted
    return bool(np.allclose(np.asarray(value), np.asarray(wanted), rtol=3e-3, atol=1e-3))


def _angle(one: np.ndarray, other: np.ndarray) -> float:
    """Radians between two rotations; exact for small ones, too."""
    return 2 * math.asin(min(1.0, float(np.linalg.norm(one - other)) / math.sqrt(8)))


def _from_euler(degrees: Vector) -> np.ndarray:
    """V-REP's: about x, then the new y, then the new z."""
    (ca, cb, cg), (sa, sb, sg) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    about_y = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    about_z = np.array([[cg, -sg, 0], [sg, cg, 0], [0, 0, 1]])
    return about_x @ about_y @ about_z
