"""Create new joints and sensors: V-REP's kinds, represented by MuJoCo's elements and annotations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import mujoco

from simx_server.errors import CommandError
from simx_server.joints.state import MODE_WORDS, JointMode
from simx_server.scene.formats.annotations import DETECTABLE_KINDS, Annotation
from simx_server.scene.naming.names import INTERNAL

from .creating import add

if TYPE_CHECKING:
    from simx_server.world.world import World

_CARRIER = INTERNAL + "carrier"
_CARRIER_MASS = 1e-3
"""Mass in kg of the body that a new joint moves, and its inertia in kg m^2: MuJoCo needs some."""

_JOINTS = {
    10: ("Revolute_joint", mujoco.mjtJoint.mjJNT_HINGE),
    11: ("Prismatic_joint", mujoco.mjtJoint.mjJNT_SLIDE),
    12: ("Spherical_joint", mujoco.mjtJoint.mjJNT_BALL),
}
_SLIDE_RANGE = (-0.5, 0.5)
"""V-REP's default range in metres."""

_VOLUMES = {30: "pyramid", 31: "cylinder", 32: "disc", 33: "cone", 34: "ray"}
"""`sim_proximitysensor_*_subtype`."""

_DETECTED = {0x10 << place: kind for place, kind in enumerate(DETECTABLE_KINDS) if place}
"""Kinds of detection by V-REP's bits, without the first one, which stands for all."""

_MOST_RAYS = 10_000


def create_joint(world: World, kind: int, mode: int, *, hybrid: bool) -> int:
    """Create a joint at the world's origin, along z; `kind` and `mode` are legacy numbers. Its motor is off.

    A free body that gets it as parent becomes its link; static bodies move with it. Raises CommandError.
    """
    if kind not in _JOINTS:
        raise CommandError(f"{kind} is no type of joint; those are 10 revolute, 11 prismatic, 12 spherical")
    words = {number: word for word, number in MODE_WORDS.items()}
    if mode not in words:
        raise CommandError(
            f"a new joint's mode is one of {', '.join(f'{int(n)} {w}' for n, w in words.items())}; not {mode}"
        )
    stem, joint_type = _JOINTS[kind]

    def build(spec: mujoco.MjSpec, name: str) -> None:
        body = spec.worldbody.add_body(name=_CARRIER)
        body.explicitinertial = True
        body.mass, body.inertia[:] = _CARRIER_MASS, _CARRIER_MASS
        joint = body.add_joint(name=name, type=joint_type, axis=[0.0, 0.0, 1.0])
        if kind == 11:
            joint.limited, joint.range[:] = int(mujoco.mjtLimited.mjLIMITED_TRUE), _SLIDE_RANGE

    note: Annotation = {"mode": words[JointMode(mode)]}
    if kind != 12:
        note |= {"motor": False, "hybrid": hybrid, "cyclic": kind == 10}
    return add(world, stem, "joint", build, {"joint": note}, hidden=(_CARRIER,))


def create_proximity_sensor(
    world: World, kind: int, detected: int, options: int, counts: Sequence[int], sizes: Sequence[float]
) -> int:
    """Create a proximity sensor and return its handle.

    Args:
        detected: the only kind of detection that counts, a bit of V-REP's special properties; 0x10: all kinds.
        counts: V-REP's 8 whole numbers; the fifth and sixth are random rays, and how many must meet a surface.
        sizes: V-REP's 15 numbers: offset, range, x, y, x far, y far, inside gap, radius, radius far, angle, greatest
            angle of normals, least distance, ... (m, rad).
        options: bits: 1 explicit, 8 no front faces, 16 no back faces, 64 angle of normals limited, 256 least distance
            counts, 512 random rays.

    Raises CommandError.
    """
    if kind not in _VOLUMES:
        raise CommandError(
            f"{kind} is no type of proximity sensor; those are "
            + ", ".join(f"{number} {word}" for number, word in _VOLUMES.items())
        )
    if len(sizes) < 12:
        raise CommandError(f"a proximity sensor is made from 15 numbers, not {len(sizes)}")
    if any(number < 0 for number in sizes[1:12]) or sizes[1] <= 0:
        raise CommandError("a proximity sensor's range is above 0 m, and only its offset may be below 0")
    note = _volume(_VOLUMES[kind], sizes) | _detection(detected, options, sizes)
    if options & 512:
        if _VOLUMES[kind] != "ray":
            raise CommandError("only sensors of the type ray have random rays")
        note |= _random_rays(counts, sizes)

    def build(spec: mujoco.MjSpec, name: str) -> None:
        spec.worldbody.add_site(name=name, size=[0.01] * 3, group=4)

    return add(world, "Proximity_sensor", "site", build, {"proximity": note})


def _volume(word: str, sizes: Sequence[float]) -> Annotation:
    offset, reach, x, y, x_far, y_far, gap, radius, radius_far, angle = sizes[:10]
    note: Annotation = {"type": word, "offset": offset, "range": reach}
    match word:
        case "pyramid":
            return note | {"size_x": x, "size_y": y, "size_x_far": x_far, "size_y_far": y_far}
        case "cylinder":
            return note | {"radius": radius, "radius_far": radius_far}
        case "disc":
            return note | {
                "angle_deg": math.degrees(angle),
                "height": y,
                "radius": radius,
                "inside_gap": gap,
            }
        case "cone":
            return note | {"angle_deg": math.degrees(angle), "radius": radius, "inside_gap": gap}
        case _:  # a ray has a range alone
            return note


def _detection(detected: int, options: int, sizes: Sequence[float]) -> Annotation:
    note: Annotation = {"explicit": bool(options & 1)}
    if options & 8 or options & 16:
        note["faces"] = "back" if options & 8 else "front"
    if options & 64:
        note["max_normal_deg"] = math.degrees(sizes[10])
    if options & 256:
        note["min_distance"] = sizes[11]
    if detected in _DETECTED:
        note["detects"] = _DETECTED[detected]
    return note


def _random_rays(counts: Sequence[int], sizes: Sequence[float]) -> Annotation:
    if len(counts) < 6 or not 1 <= counts[5] <= counts[4] <= _MOST_RAYS:
        raise CommandError(
            f"random rays are 1 to {_MOST_RAYS}, and the number that must meet a surface is not greater"
        )
    return {
        "type": "random_rays",
        "rays": counts[4],
        "rays_needed": counts[5],
        "angle_deg": math.degrees(sizes[9]),
        "radius": sizes[7],
        "inside_gap": sizes[6],
    }


def create_vision_sensor(world: World, options: int, resolution: Sequence[int], view: Sequence[float]) -> int:
    """Create a vision sensor and return its handle.

    Args:
        options: bits: 1 explicit, 2 perspective, 16 external input, 128 with its own background.
        view: near, far (m), perspective angle (rad) or orthographic size (m), three sizes of the box, and the RGB
            0..1 of pixels that see nothing.

    Raises CommandError for values that a camera cannot have.
    """
    if len(resolution) < 2 or len(view) < 3:
        raise CommandError("a vision sensor is made from 4 whole numbers and 11 others")
    (width, height), (near, far, angle) = resolution[:2], view[:3]
    if not (0 < width <= 4096 and 0 < height <= 4096 and 0 < near < far and angle > 0):
        raise CommandError(
            "a vision sensor has 1 to 4096 pixels a side, 0 < near < far plane and an angle or size above 0"
        )
    note: Annotation = {
        "near": near,
        "far": far,
        "explicit": bool(options & 1),
        "external": bool(options & 16),
    }
    if options & 128 and len(view) >= 9:
        note["background"] = ",".join(f"{min(max(part, 0.0), 1.0):.6g}" for part in view[6:9])
    perspective = bool(options & 2)
    if perspective:
        if angle >= math.pi:
            raise CommandError(f"a perspective angle is below pi rad, not {angle}")
        note["angle_deg"] = math.degrees(angle)

    def build(spec: mujoco.MjSpec, name: str) -> None:
        # MuJoCo's cameras look along -z, V-REP's sensors along z: half a turn about y.
        camera = spec.worldbody.add_camera(name=name, quat=[0.0, 0.0, 1.0, 0.0])
        camera.resolution[:] = width, height
        if not perspective:
            camera.proj = mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC
            camera.fovy = angle / max(1.0, width / height)

    return add(world, "Vision_sensor", "camera", build, {"vision": note})


def create_force_sensor(world: World, options: int, counts: Sequence[int], limits: Sequence[float]) -> int:
    """Create a force sensor and return its handle.

    Args:
        options: bits: 1 force, 2 torque breaks it.
        counts: filter (0 mean, 1 median), samples, violations.
        limits: size, force (N), torque (N m).

    Raises CommandError.
    """
    if len(counts) < 3 or len(limits) < 3:
        raise CommandError("a force sensor is made from 5 whole numbers and 5 others")
    note: Annotation = {
        "filter": "median" if counts[0] == 1 else "average",
        "samples": max(1, counts[1]),
        "violations": max(1, counts[2]),
    }
    for bit, key, limit in ((1, "max_force", limits[1]), (2, "max_torque", limits[2])):
        if options & bit:
            if limit <= 0:
                raise CommandError(f"a force sensor's threshold is above 0, not {limit}")
            note[key] = limit

    def build(spec: mujoco.MjSpec, name: str) -> None:
        # The sensor needs a separate body: in the world itself nothing could hold it.
        spec.worldbody.add_body(name=_CARRIER).add_site(name=name, size=[0.01] * 3, group=4)
        for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
            spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=name)

    return add(world, "Force_sensor", "site", build, {"force": note})
