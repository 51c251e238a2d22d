"""Properties of shapes. A shape is its own mesh: it has the properties of both."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.editing.shape_looks import part_texture
from simx_server.sim_api.object_model.types import enum_of
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed, numbered
from simx_server.sim_api.properties.tables.shapes import SHAPES

from .making import Old, engine_properties, kept, refused

if TYPE_CHECKING:
    from simx_server.world.world import World

_OLD = Old(SHAPES)
_FILE = "the form of a mesh and its texture come from the scene's file"


def _list_of(name: str, first: Any) -> Property:
    """Return a value of each mesh of a compound: a shape is one mesh."""
    one = _OLD[name]
    get, put = one.get, one.set
    is_color = one.type is t.COLOR

    def read(world: World, handle: int) -> list[float]:
        found = get(world, handle) if get else first
        return list(found) if is_color else [found]

    def write(world: World, handle: int, values: list[float]) -> None:
        assert put is not None
        put(world, handle, values[:3] if is_color else values[0])

    return Property(f"compoundColors.{name.rpartition('.')[2]}", t.FLOAT_ARRAY, read, write)


def _texture(world: World, handle: int) -> int:
    """Return the number of a shape's texture, -1 for none."""
    found = (world.textures.of_geom(each.geom) for each in world.shape_colors.parts(handle))
    return next((each for each in found if each >= 0), -1)


def _pixels(world: World, handle: int) -> tuple[list[int], bytes]:
    """Return width and height, and the bytes of a shape's texture; nothing without one."""
    number = _texture(world, handle)
    if number == -1:
        return [0, 0], b""
    pixels = world.textures.pixels(number)
    height, width = pixels.shape[:2]
    return [width, height], pixels.tobytes()


def _coordinates(world: World, handle: int) -> list[float]:
    """Return u and v of the texture at the corners of the triangles; none for a shape without such a texture."""
    model = world.simulation.model
    found = (part_texture(model, each.geom) for each in world.shape_colors.parts(handle))
    return next((each.coordinates.ravel().tolist() for each in found if each is not None), list[float]())


MESH = (
    *_OLD.same("color.diffuse color.specular color.emission color.transparency indices"),
    _OLD.matrix("vertices", "vertices", 3),
    _OLD.matrix("normals", "normals", 3),
    Property("shape", t.HANDLE, lambda _world, handle: handle),
    Property("shapeUid", t.INT, lambda world, handle: world.simulation.scene_id * 1_000_000 + handle),
    kept("colorName", t.STRING, ""),
    kept("wireframe", t.BOOL, False),
    kept("culling", t.BOOL, False),
    kept("showEdges", t.BOOL, False),
    kept("shadingAngle", t.FLOAT, 0.0),
    kept("texture.interpolate", t.BOOL, True),
    kept("texture.repeatU", t.BOOL, True),
    kept("texture.repeatV", t.BOOL, True),
    Property("texture.id", t.INT, _texture),
    Property("texture.resolution", t.INT_ARRAY2, lambda world, handle: _pixels(world, handle)[0]),
    Property("texture.image", t.BUFFER, lambda world, handle: _pixels(world, handle)[1], is_large=True),
    Property("texture.coordinates", t.FLOAT_ARRAY, _coordinates, is_large=True),
    fixed("texture.applyMode", enum_of("textureApplyMode"), 0, "a texture is multiplied with the colour"),
)
"""Properties of class mesh that a shape has; `convex` and `primitive` are those of the shape."""


_ENGINE = tuple(
    _OLD.named(f"mujoco.{name}", f"dynamics.mujoco.{name}")
    for name in ("friction", "solref", "solimp", "solmix", "margin", "condim", "priority")
)

SHAPE = (
    *_OLD.same(
        "dynamic respondable respondableMask initLinearVelocity initAngularVelocity compound primitive convex"
    ),
    *_OLD.same("mass centerOfMass pmiQuaternion meshes"),
    _OLD.named("dynLinearVelocity", "dynamics.linearVelocity"),
    _OLD.named("dynAngularVelocity", "dynamics.angularVelocity"),
    _OLD.matrix("inertia", "inertiaMatrix", 3, by_rows=True),
    _OLD.named("principalMomentOfInertia", "pmi", t.VECTOR3),
    *_OLD.same("applyColor.diffuse applyColor.specular applyColor.emission applyColor.transparency"),
    _list_of("color.diffuse", [0.5, 0.5, 0.5]),
    _list_of("color.specular", [0.0, 0.0, 0.0]),
    _list_of("color.emission", [0.0, 0.0, 0.0]),
    _list_of("color.transparency", 0.0),
    kept("compoundCullings", t.INT_ARRAY, [0]),
    kept("compoundEdges", t.INT_ARRAY, [0]),
    kept("compoundWireframe", t.INT_ARRAY, [0]),
    kept("compoundShadingAngles", t.FLOAT_ARRAY, [0.0]),
    kept("applyCulling", t.BOOL, False),
    kept("applyShowEdges", t.BOOL, False),
    kept("applyShadingAngle", t.FLOAT, 0.0),
    numbered("kinematic", t.BOOL, "shapeintparam_kinematic"),
    numbered("startInDynSleepMode", t.BOOL, "shapeintparam_sleepmodestart"),
    refused("setToDynamicWithParent", t.BOOL, "a shape becomes dynamic only by its property 'dynamic'"),
    refused("flipFaces", t.BOOL, _FILE),
    engine_properties(_ENGINE),
    *_ENGINE,
    *MESH,
)
