"""Create new objects, in a stopped or running scene: shapes from sizes, points and heights.

The stop removes objects created during a run, as V-REP does when it resets the scene. Objects are static by default:
they stay where they are put. Like V-REP's, they have their frame in the middle of their shape.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.errors import CommandError
from simx_server.scene.editing.waiting.templates import Template, template_of
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.loader import prepare
from simx_server.scene.formats.loose_meshes import settle

from .grafts.grafting import Graft, graft
from .grafts.late import may_wait

if TYPE_CHECKING:
    from simx_server.world.world import World

GREY = (0.9, 0.9, 0.9, 1.0)
"""Colour of V-REP's new shapes."""

THICKNESS = 1e-3
"""Thickness of planes and discs in metres."""

_AROUND = 32
"""Number of corners around a cone."""

_LARGEST = 1e4
"""Largest size in metres."""

_LEAST_MASS, _LARGEST_MASS = 1e-6, 1e4
"""V-REP's limits, kg."""

_MOST_POINTS = _MOST_TRIANGLES = 20_000
"""Of a mesh. MuJoCo compiles a triangle in about 10 us; larger ones come as files, which are tried elsewhere first."""

_MOST_HEIGHTS = 250_000

_GEOM = mujoco.mjtGeom


@dataclass(frozen=True)
class Body:
    """The physical properties of a new shape."""

    static: bool = True
    respondable: bool = False
    mass: float = 1.0
    """Mass in kilograms."""
    lacks: tuple[str, ...] = ()
    """Of collidable, measurable, detectable (`scene.abilities`): what the shape is not, until a program says so."""


def add(
    world: World,
    stem: str,
    element: str,
    build: Callable[[mujoco.MjSpec, str], None],
    notes: Mapping[str, Annotation] | None = None,
    hidden: Sequence[str] = (),
    template: Callable[[mujoco.MjSpec, str], Template] | None = None,
) -> int:
    """Add the object that `build` makes in an empty spec under a given name; return its handle.

    Args:
        stem: the name, which gets a number if it is taken.
        element: the kind of element that carries the object.
        build: makes the element in a spec, given its name.
        notes: annotations by kind.
        hidden: names of bodies without an object.
        template: returns the object that is made, given spec and name; by default the spec is compiled to find it.

    Raises CommandError.
    """
    sim = world.simulation
    taken = sim.scene.by_names()
    name, number = stem, 0
    while name in taken:
        name, number = f"{stem}{number}", number + 1
    spec = mujoco.MjSpec()
    build(spec, name)
    prepare(spec)
    own = {kind: dict(note) for kind, note in notes.items()} if notes else {}
    names, annotations = {(element, name): name}, {name: own} if own else {}

    def found() -> Template | None:
        return template(spec, name) if template else template_of(spec, names, annotations, hidden)

    addition = Graft(spec, names, annotations, hidden=hidden, template=found)
    handles = graft(sim, addition, late=may_wait(world, addition))
    world.object_settings.apply_masks()
    sim.changed()
    return handles[element, name]


def create_primitive(world: World, kind: str, sizes: Sequence[float], body: Body) -> int:
    """Create a plane, disc, cuboid, spheroid, cylinder, cone or capsule of these sizes along x, y, z (metres).

    Sizes and masses out of V-REP's limits become the nearest within. Raises CommandError: there are fewer sizes.
    """
    if len(sizes) < 3:
        raise CommandError(f"a shape has three sizes, not {list(sizes)}")
    body = replace(body, mass=min(max(body.mass, _LEAST_MASS), _LARGEST_MASS))
    x, y, z = (min(max(size, THICKNESS), _LARGEST) / 2 for size in sizes[:3])

    def fill(spec: mujoco.MjSpec, geom: Any) -> None:
        match kind:
            case "plane" | "cuboid":
                geom.type, geom.size[:] = _GEOM.mjGEOM_BOX, (x, y, THICKNESS / 2 if kind == "plane" else z)
            case "disc" | "cylinder":
                half = THICKNESS / 2 if kind == "disc" else z
                geom.type, geom.size[:2] = _GEOM.mjGEOM_CYLINDER, (x, half)
            case "spheroid" if x == y == z:
                geom.type, geom.size[0] = _GEOM.mjGEOM_SPHERE, x
            case "spheroid":
                geom.type, geom.size[:] = _GEOM.mjGEOM_ELLIPSOID, (x, y, z)
            case "capsule" if z > x:
                geom.type, geom.size[:2] = _GEOM.mjGEOM_CAPSULE, (x, z - x)
            case "capsule":
                geom.type, geom.size[0] = _GEOM.mjGEOM_SPHERE, x
            case _:
                _use_mesh(spec, geom, *_cone(x, y, z))

    is_form = kind != "cone" and all(map(math.isfinite, (x, y, z, body.mass)))
    return _add_shape(world, kind.capitalize(), fill, body, template=_form if is_form else None)


def _form(spec: mujoco.MjSpec, name: str) -> Template:
    """Return a shape of a form that MuJoCo knows: its compile cannot fail."""
    return Template.of_shape(name, is_free=bool(spec.body(name).joints))


def create_mesh(world: World, points: np.ndarray, faces: np.ndarray, stem: str, body: Body) -> int:
    """Create a shape of triangles: points (n, 3) in the world, metres, and faces (m, 3) of their indices.

    Raises CommandError: no surface.
    """
    if len(points) < 3 or len(faces) < 1 or len(points) > _MOST_POINTS:
        raise CommandError(f"a mesh has from 3 to {_MOST_POINTS} points and at least one triangle")
    if len(faces) > _MOST_TRIANGLES:
        raise CommandError(
            f"a mesh has at most {_MOST_TRIANGLES} triangles, not {len(faces)}; load it from a file"
        )
    if faces.min() < 0 or faces.max() >= len(points):
        raise CommandError(f"a triangle's corners are indices from 0 to {len(points) - 1} here")
    if len(points) == 3:  # MuJoCo wants four, of which one may belong to no triangle
        points = np.vstack([points, points.mean(axis=0)])
    centre = (points.min(axis=0) + points.max(axis=0)) / 2

    def fill(spec: mujoco.MjSpec, geom: Any) -> None:
        _use_mesh(spec, geom, points - centre, faces)
        settle(geom)
        _weigh_flat(geom, points.max(axis=0) - points.min(axis=0), body.mass)

    return _add_shape(world, stem, fill, body, tuple(centre))


def create_height_field(world: World, heights: np.ndarray, width: float) -> int:
    """Create a static surface: heights (rows along y, columns along x) in metres, `width` along x in metres.

    Raises CommandError: less than 2 x 2 heights, or no width.
    """
    rows, columns = heights.shape
    if rows < 2 or columns < 2 or not 0 < width <= _LARGEST or heights.size > _MOST_HEIGHTS:
        raise CommandError(
            f"a height field has 2 x 2 points or more, at most {_MOST_HEIGHTS}, and a width above 0 m"
        )
    low, high = float(heights.min()), float(heights.max())
    rise, middle = max(high - low, THICKNESS), (low + high) / 2
    depth = width * (rows - 1) / (columns - 1)

    def fill(spec: mujoco.MjSpec, geom: Any) -> None:
        spec.add_hfield(
            name="heights",
            nrow=rows,
            ncol=columns,
            size=[width / 2, depth / 2, rise, max(rise, 0.1)],
            userdata=((heights - low) / rise).ravel(),
        )
        geom.type, geom.hfieldname = _GEOM.mjGEOM_HFIELD, "heights"
        geom.pos[2] = low - middle

    body = Body(respondable=True, lacks=("collidable", "measurable"))
    return _add_shape(world, "Heightfield", fill, body, (0.0, 0.0, middle))


def _add_shape(
    world: World,
    stem: str,
    fill: Callable[[mujoco.MjSpec, Any], None],
    body: Body,
    place: Sequence[float] = (0.0, 0.0, 0.0),
    template: Callable[[mujoco.MjSpec, str], Template] | None = None,
) -> int:
    def build(spec: mujoco.MjSpec, name: str) -> None:
        made = spec.worldbody.add_body(name=name, pos=list(place))
        if not body.static:
            made.add_freejoint()
        geom = made.add_geom(rgba=list(GREY), mass=body.mass)
        geom.contype = geom.conaffinity = int(body.respondable)
        fill(spec, geom)

    notes: dict[str, Annotation] = {"shape": dict.fromkeys(body.lacks, False)} if body.lacks else {}
    handle = add(world, stem, "body", build, notes, template=template)
    if world.simulation.waiting is not None:
        world.simulation.waiting.plain.add(handle)
    return handle


def _weigh_flat(geom: Any, sides: np.ndarray, mass: float) -> None:
    """Give the body of a flat mesh the inertia of a plate: by its own, rounded, MuJoCo may refuse it."""
    if sides.min() > THICKNESS:
        return
    squares = np.maximum(sides, THICKNESS) ** 2
    made = geom.parent
    made.explicitinertial, made.mass = True, mass
    made.ipos[:], made.iquat[:] = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
    made.inertia[:] = mass / 12 * (squares.sum() - squares)


def _use_mesh(spec: mujoco.MjSpec, geom: Any, points: np.ndarray, faces: np.ndarray) -> None:
    spec.add_mesh(
        name="mesh",
        uservert=points.ravel(),
        userface=faces.ravel().astype(np.int32),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    geom.type, geom.meshname = _GEOM.mjGEOM_MESH, "mesh"


def _cone(x: float, y: float, z: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points and faces of a cone with these half sizes."""
    angles = [2 * math.pi * step / _AROUND for step in range(_AROUND)]
    points = [(x * math.cos(a), y * math.sin(a), -z) for a in angles] + [(0.0, 0.0, z), (0.0, 0.0, -z)]
    faces = [
        face
        for step in range(_AROUND)
        for face in (
            (step, (step + 1) % _AROUND, _AROUND),
            ((step + 1) % _AROUND, step, _AROUND + 1),
        )
    ]
    return np.array(points), np.array(faces)
