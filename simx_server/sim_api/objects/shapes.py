"""Creation of shapes and other objects by scripts; colours, meshes and masses of shapes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from simx_server.editing import creating, creating_parts, shape_looks, shape_properties
from simx_server.editing.compounds import relocating
from simx_server.editing.creating import Body
from simx_server.errors import CommandError, Unsupported
from simx_server.parts.object_settings import DrawnSize
from simx_server.parts.shape_colors import AMBIENT_DIFFUSE
from simx_server.scene.editing import marks
from simx_server.scene.geometry import lights
from simx_server.scene.geometry.letters import text_mesh
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.poses import IDENTITY
from simx_server.scripting.interpreter import Constant
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

_PURE = ("cuboid", "spheroid", "cylinder", "cone")
"""Types of sim.createPureShape, from 0."""

_PRIMITIVES = {1: "plane", 2: "disc", 3: "cuboid", 4: "spheroid", 5: "cylinder", 6: "cone", 8: "capsule"}
"""sim.primitiveshape_*."""

_RESPONDABLE, _STATIC = 8, 16
"""Bits of the options of sim.createPureShape."""

_COMPOUND, _IS_PURE, _CONVEX = 1, 2, 4
"""Bits of the result of sim.getShapeGeomInfo."""


_POINT_SIZE, _VISION_SIZE = 12, 3
"""Places of sizes in the numbers of new proximity and vision sensors."""

_LONGEST_TEXT, _HIGHEST_TEXT = 200, 100
"""Limits of a text that becomes a shape: characters, and metres."""


class ShapeFunctions(ApiPart, effect="changes"):
    """Functions for shapes: metres, kilograms, colours 0..1. Objects created during a run are removed at its stop."""

    CONSTANTS: ClassVar[Mapping[str, Constant]] = {
        **{
            f"{start}_{shape}": number
            for start in ("pure_primitive", "primitiveshape")
            for number, shape in enumerate(
                ("none", "plane", "disc", "cuboid", "spheroid", "cylinder", "cone", "heightfield", "capsule")
            )
        },
    }

    def createPureShape(
        self, kind: int, options: int, sizes: list[float], mass: float, _precision: list[int] | None = None
    ) -> int:
        """Create a shape and return its handle. `kind`: 0 cuboid, 1 sphere, 2 cylinder, 3 cone; `options`: bit 3
        respondable, bit 4 static. As in V-REP the shape is not collidable, measurable or detectable until
        sim.setObjectSpecialProperty says so.

        Partly: the drawing of edges and back faces, and open ends of cylinders, are ignored.
        """
        if not 0 <= kind < len(_PURE):
            raise CommandError(f"a pure shape is 0 cuboid, 1 sphere, 2 cylinder or 3 cone, not {kind}")
        body = Body(
            static=bool(options & _STATIC),
            respondable=bool(options & _RESPONDABLE),
            mass=mass,
            lacks=("collidable", "measurable", "detectable"),
        )
        return creating.create_primitive(self._world, _PURE[kind], sizes, body)

    def createPrimitiveShape(self, kind: int, sizes: list[float], _options: int = 0) -> int:
        """Create a sim.primitiveshape_*, static and not respondable. Since CoppeliaSim 4.

        Partly: planes and discs are 1 mm thick; the drawing of edges and back faces is ignored.
        """
        if kind not in _PRIMITIVES:
            known = ", ".join(f"{number} {word}" for number, word in _PRIMITIVES.items())
            raise CommandError(f"{kind} is no primitive shape; those are {known}")
        return creating.create_primitive(self._world, _PRIMITIVES[kind], sizes, Body())

    def generateTextShape(
        self,
        text: str,
        color: list[float] | None = None,
        height: float = 0.1,
        centered: bool = False,
        alphabet: str | None = None,
    ) -> int:
        """Create a static shape, not respondable, of a text in the x-y plane, and return its handle; its frame is
        where the first line starts, or at its middle. `color`: RGB 0..1; `height`: that of a capital letter.

        Partly: one shape has all letters, in the server's font and with the characters of ASCII; an alphabet model
        is an error.
        """
        if alphabet:
            raise Unsupported("letters are those of the server's font; leave out the model of an alphabet")
        if not 0 < height <= _HIGHEST_TEXT or len(text) > _LONGEST_TEXT:
            raise CommandError(
                f"a text has up to {_LONGEST_TEXT} characters, and its height is above 0, up to {_HIGHEST_TEXT} m"
            )
        shown = [1.0, 1.0, 1.0] if color is None else color
        if len(shown) < 3:
            raise CommandError(f"a colour is {{red, green, blue}}, not {len(shown)} numbers")
        points, faces = text_mesh(text, height, centred=centered)
        if not len(points):
            raise CommandError("the text has no character that can be seen")
        handle = creating.create_mesh(self._world, points, faces, "Text", Body())
        relocating.relocate(self._world, handle, IDENTITY)
        self._world.shape_colors.set(
            handle, AMBIENT_DIFFUSE, [min(max(part, 0.0), 1.0) for part in shown[:3]]
        )
        return handle

    def createHeightfieldShape(
        self,
        _options: int,
        _shading_angle: float,
        x_count: int,
        y_count: int,
        x_size: float,
        heights: list[float],
    ) -> int:
        """Create a static height field, not collidable or measurable; `heights` are rows along y of `x_count` points
        each.

        Partly: drawing options are ignored.
        """
        if x_count < 2 or y_count < 2 or len(heights) < x_count * y_count:
            raise CommandError(
                f"{x_count} x {y_count} points need {x_count * y_count} heights, not {len(heights)}"
            )
        field = np.array(heights[: x_count * y_count], float).reshape(y_count, x_count)
        return creating.create_height_field(self._world, field, x_size)

    def createJoint(
        self,
        kind: int,
        mode: int,
        options: int,
        sizes: list[float] | None = None,
        _color: list[float] | None = None,
        _other_color: list[float] | None = None,
    ) -> int:
        """Create a joint at the origin, along z, with the motor off; bit 0 of `options`: hybrid operation.

        It carries an object that gets it as parent: a static shape, or the first dynamic one, which it links. `sizes`:
        length and diameter (m), as the properties `jointLength` and `jointDiameter`; no view shows them, nor colours.
        """
        if sizes is not None and len(sizes) < 2:
            raise CommandError(f"sizes of a joint are its length and its diameter, not {len(sizes)} numbers")
        handle = creating_parts.create_joint(self._world, kind, mode, hybrid=bool(options & 1))
        if sizes is not None:
            item = self._sim.scene.get(handle)
            usual = marks.joint_sizes(item)
            given = (size if size > 0 else first for size, first in zip(sizes, usual, strict=False))
            marks.set_joint_sizes(self._sim, item, *given)
        return handle

    def createProximitySensor(
        self,
        kind: int,
        detected: int,
        options: int,
        counts: list[int],
        sizes: list[float],
        _color: list[float] | None = None,
    ) -> int:
        """Create a sensor at the origin that looks along z. `detected`: sim.objectspecialproperty_detectable_infrared,
        _laser, _inductive or _capacitive, if only shapes that are detectable so count; 16: all. Volumes are exact,
        whatever the `counts` of their faces and subdivisions; option 512: a ray sensor has `counts[5]` random rays, of
        which `counts[6]` must meet a surface. The last size is that of its point, `sensorPointSize`.
        """
        handle = creating_parts.create_proximity_sensor(self._world, kind, detected, options, counts, sizes)
        if len(sizes) > _POINT_SIZE:
            self._keep_size(handle, DrawnSize.SENSOR_POINT, sizes[_POINT_SIZE])
        return handle

    def createVisionSensor(
        self, options: int, counts: list[int], view: list[float], _color: list[float] | None = None
    ) -> int:
        """Create a sensor at the origin that looks along z. The fourth number of `view` is its `sensorSize`.

        Partly: it has no separate lights (option 32). Images never show fog.
        """
        handle = creating_parts.create_vision_sensor(self._world, options, counts, view)
        if len(view) > _VISION_SIZE:
            self._keep_size(handle, DrawnSize.SENSOR, view[_VISION_SIZE])
        return handle

    def createForceSensor(
        self, options: int, counts: list[int], limits: list[float], _color: list[float] | None = None
    ) -> int:
        """Create a sensor at the origin. The first of `limits` is its `sensorSize`; no view shows it, nor colours."""
        handle = creating_parts.create_force_sensor(self._world, options, counts, limits)
        self._keep_size(handle, DrawnSize.SENSOR, limits[0])
        return handle

    def setShapeMaterial(self, _shape: int, _material: int) -> int:
        """Return 1. Stand-in: the scene file defines friction and similar properties of each geom."""
        raise Unsupported(
            "there are no materials of physics here; friction and stiffness are attributes of geoms in the scene file"
        )

    @reads
    def getShapeGeomInfo(self, shape: int) -> tuple[int, int, list[float]]:
        """Return bits (0 compound, 1 pure, 2 convex), the sim.pure_primitive_* of a single shape, and its sizes x, y,
        z and 0.
        """
        handle = self._self(shape)
        number, sizes = shape_looks.pure_type(self._world, handle)
        bits = _COMPOUND if shape_properties.is_compound(self._sim, handle) else 0
        bits |= _IS_PURE if number else 0
        bits |= _CONVEX if shape_looks.is_convex(self._world, handle) else 0
        return bits, number, [*sizes, 0.0]

    @reads
    def getLightParameters(self, light: int) -> tuple[int, list[float], list[float], list[float]]:
        """Return 1 when the light is on, {0, 0, 0}, its colour, and the colour of its highlights."""
        on, diffuse, specular = lights.light(self._sim, self._self(light))
        return int(on), [0.0] * 3, diffuse, specular

    def setLightParameters(
        self,
        light: int,
        on: int,
        _ambient: list[float] | None = None,
        diffuse: list[float] | None = None,
        specular: list[float] | None = None,
    ) -> int:
        """Set a light; nil keeps a colour."""
        lights.set_light(self._sim, self._self(light), bool(on), diffuse, specular)
        return 1

    @reads
    def getShapeMass(self, shape: int) -> float:
        """Return the mass in kilograms. Since CoppeliaSim 4."""
        return shape_properties.get_mass(self._sim, self._self(shape))

    def setShapeMass(self, shape: int, mass: float) -> None:
        """Set the mass in kilograms; the inertia changes in proportion. Since CoppeliaSim 4."""
        shape_properties.set_mass(self._sim, self._self(shape), mass)

    def _keep_size(self, handle: int, size: DrawnSize, value: float) -> None:
        """Store a size in metres; 0 and below stand for the usual one."""
        if value > 0:
            self._world.object_settings.keep(handle, size, value)

    def _shape(self, handle: int) -> int:
        return self._sim.scene.get_kind(self._self(handle), ObjectKind.SHAPE).handle
