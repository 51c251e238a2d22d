"""Path objects: sites with the control points as an annotation, and a mesh where the path has a visible form."""

from __future__ import annotations

import math
from itertools import pairwise

import mujoco
import numpy as np

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scene.formats.texts.path_points import MOST_POINTS, text_of
from simx_server.scene.formats.vrep.objects import Dummy, Leaf, Path, PathPoint
from simx_server.scene.geometry.curve import ControlPoint, Curve, Method, Rules
from simx_server.scene.geometry.sweep import sweep
from simx_server.scene.poses.poses import Pose

from .context import Conversion
from .geometry.looks import Looks
from .geometry.meshes import Meshes
from .shapes import SEEN, UNDRAWN

_RENDERABLE = 0x200
_HALF_THICKNESS = 1e-3
"""Of sheets, in metres: lines on a floor lie in its very plane, and V-REP draws them above it."""
_SAME = 1e-9
_MOST_COUNT = 1000
_NOT_FINITE = "paths with control points that are no finite numbers have none"
_NO_FORM = "the visible form of a path is left out"


def add_path(conversion: Conversion, path: Path, body: mujoco.MjsBody, at: Pose) -> None:
    """Add a path.

    Args:
        conversion: the conversion.
        path: the path.
        body: the body on which it rides.
        at: its frame in that body.
    """
    name = conversion.name(path)
    leaf = _form_of(conversion, path)
    mesh = None if leaf is None else Meshes.of(conversion).look_of(leaf, name, None)
    if leaf is None or mesh is None:
        body.add_site(name=name, pos=at[0], quat=at[1], group=4)
    else:
        own = body.add_body(name=name, pos=at[0], quat=at[1])
        geom = own.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, mass=0.0)
        geom.contype = geom.conaffinity = 0
        geom.group = SEEN if path.properties & _RENDERABLE else UNDRAWN
        geom.material = Looks.of(conversion).material_of(leaf, texture=False)
    _annotate(conversion, path, name)


def add_followers(conversion: Conversion) -> None:
    """Annotate the dummies that follow their parent paths; called when all objects were added."""
    objects = conversion.file.objects
    for item in objects.values():
        if not isinstance(item, Dummy) or item.path_offset is None:
            continue
        if isinstance(objects.get(item.parent), Path):
            conversion.annotate("follow", conversion.name(item), offset=item.path_offset)


def _annotate(conversion: Conversion, path: Path, name: str) -> None:
    points = [_numbers_of(point) for point in path.points[:MOST_POINTS]]
    if len(path.points) > MOST_POINTS:
        conversion.report.leave_out(f"control points of paths beyond the first {MOST_POINTS}", name)
    if not all(math.isfinite(number) for point in points for number in point):
        conversion.report.leave_out(_NOT_FINITE, name)
        points = []
    rules = _rules_of(path)
    orientation = None
    if rules.follows_curve:
        orientation = "curve_x_up" if rules.keeps_x_up else "curve"
    conversion.annotate("object", name, type="path")
    conversion.annotate(
        "path",
        name,
        points=text_of(points) if points else None,
        closed=True if rules.is_closed else None,
        length=rules.method.name.lower(),
        angle_to_length=rules.angle_to_length,
        virtual_to_length=rules.virtual_to_length if rules.virtual_to_length != 1.0 else None,
        orientation=orientation,
        flat=True if rules.is_flat else None,
        position=path.position if path.position else None,
        velocity=path.target_velocity if path.target_velocity else None,
    )


def _numbers_of(point: PathPoint) -> tuple[float, ...]:
    """Return a control point's numbers in the order of the annotation."""
    before, after = (min(max(factor, 0.0), 1.0) for factor in point.bezier)
    count = min(max(point.bezier_points, 1), _MOST_COUNT)
    virtual = max(0.0, point.virtual_distance)
    place, turn = point.pose
    return (*place, *turn, before, after, count, virtual, point.velocity, point.flags, *point.channels)


def _rules_of(path: Path) -> Rules:
    bits = path.attributes
    return Rules(
        is_closed=path.is_closed,
        method=Method(path.length_method) if path.length_method in set(Method) else Method.DISTANCE_OR_ANGLE,
        angle_to_length=max(0.0, path.angle_to_length),
        virtual_to_length=max(0.0, path.virtual_to_length),
        follows_curve=bool(bits & c.sim_pathproperty_automatic_orientation),
        keeps_x_up=bool(bits & c.sim_pathproperty_keep_x_up),
        is_flat=bool(bits & c.sim_pathproperty_flat_path),
    )


def _form_of(conversion: Conversion, path: Path) -> Leaf | None:
    """Return the visible form of a path in its frame; None where it has none."""
    if not path.is_shaped or len(path.section) < 2 or len(path.points) < 2:
        return None
    points = [
        ControlPoint(
            each.pose,
            *(min(max(factor, 0.0), 1.0) for factor in each.bezier),
            count=min(max(each.bezier_points, 1), _MOST_COUNT),
        )
        for each in path.points[:MOST_POINTS]
    ]
    try:
        curve = Curve(points, _rules_of(path))
        rings = _spaced([point.pose for point in curve.points], path.section_spacing)
        if path.is_closed:
            rings = rings[:-1]
        corners, faces = sweep(rings, _thick(path.section), is_closed=path.is_closed)
    except CommandError:
        conversion.report.leave_out(_NO_FORM, conversion.name(path))
        return None
    return Leaf(
        vertices=corners.astype(np.float32),
        triangles=faces.astype(np.int32),
        material=path.section_color,
        culls_backfaces=True,
    )


def _spaced(poses: list[Pose], spacing: float) -> list[Pose]:
    """Return the poses at which the section is repeated: the first, the last, and those far enough apart."""
    found = poses[:1]
    for pose in poses[1:-1]:
        if math.dist(found[-1][0], pose[0]) >= spacing:
            found.append(pose)
    return found + poses[-1:]


def _thick(section: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return a closed section; an open one gets a thickness."""
    if math.dist(section[0], section[-1]) < _SAME:
        return section
    ways = [(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(section)]
    upper: list[tuple[float, float]] = []
    lower: list[tuple[float, float]] = []
    for (x, y), before, after in zip(section, [ways[0], *ways], [*ways, ways[-1]], strict=True):
        along = (before[0] + after[0], before[1] + after[1])
        length = math.hypot(*along) or 1.0
        dx, dy = -along[1] / length * _HALF_THICKNESS, along[0] / length * _HALF_THICKNESS
        upper.append((x + dx, y + dy))
        lower.append((x - dx, y - dy))
    return [*upper, *reversed(lower), upper[0]]
