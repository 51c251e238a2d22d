"""Properties of all scene objects."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.joints import JointMode
from simx_server.scene.objects import ObjectKind
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, bit_of
from simx_server.sim_api.properties.tables.objects import OBJECTS
from simx_server.sim_api.properties.tables.places import PLACES
from simx_server.sim_api.properties.tables.shapes import SHAPES

from .making import Old, by_name, kept, refused

if TYPE_CHECKING:
    from simx_server.world.world import World

_OLD = Old((*OBJECTS, *PLACES))
_IS_DYNAMIC = by_name(SHAPES)["dynamic"]
NOT_DYNAMIC = c.sim_modelproperty_not_dynamic


def _angular_velocity(world: World, handle: int) -> list[float]:
    return list(world.velocities.measure(handle)[2])


def _size(world: World, handle: int) -> list[float]:
    get = _OLD["bbHSize"].get
    assert get is not None
    return [2 * each for each in get(world, handle)]


def _tree(world: World, handle: int) -> list[int]:
    return [handle, *world.simulation.scene.descendants(handle)]


def _lasting_id(world: World, handle: int) -> str:
    """Return a text that an object keeps as long as its scene's file names it the same."""
    return hashlib.sha256(
        world.simulation.scene.get(handle).name.encode("utf-8", "surrogateescape")
    ).hexdigest()[:32]


def _model_hash(world: World, handle: int) -> str:
    """Return a text that changes with the names, kinds and order of the objects of a model; '' if it is none."""
    scene = world.simulation.scene
    if not scene.is_model_base(handle):
        return ""
    parts = "\n".join(f"{int(scene.get(each).kind)} {scene.get(each).alias}" for each in _tree(world, handle))
    return hashlib.sha256(parts.encode("utf-8", "surrogateescape")).hexdigest()[:32]


def _is_simulated(world: World, handle: int) -> bool:
    """Return whether physics moves an object now: a dynamic shape, a joint in dynamic mode, while the run lasts."""
    item = world.simulation.scene.get(handle)
    if not world.simulation.is_running or world.simulation.scene.overridden(handle) & NOT_DYNAMIC:
        return False
    if item.kind == ObjectKind.JOINT:
        return world.simulation.joints.mode(handle) == JointMode.FORCE
    return item.kind == ObjectKind.SHAPE and bool(_IS_DYNAMIC.get and _IS_DYNAMIC.get(world, handle))


_MOVES = kept("mov.optionsFlags", t.INT, 0)
_AXES = kept("mov.preferredAxesFlags", t.INT, 0)

_MOV = (
    _MOVES,
    bit_of(_MOVES, "mov.translNoSim", 1, inverted=True),
    bit_of(_MOVES, "mov.translInSim", 2, inverted=True),
    bit_of(_MOVES, "mov.rotNoSim", 4, inverted=True),
    bit_of(_MOVES, "mov.rotInSim", 8, inverted=True),
    bit_of(_MOVES, "mov.altTransl", 0x20),
    bit_of(_MOVES, "mov.altRot", 0x40),
    _AXES,
    *(bit_of(_AXES, f"mov.prefTransl{axis}", 1 << place) for place, axis in enumerate("XYZ")),
    *(bit_of(_AXES, f"mov.prefRot{axis}", 8 << place) for place, axis in enumerate("XYZ")),
    kept("mov.relativity", t.INT_ARRAY, [0, 0]),
    kept("mov.stepSize", t.FLOAT_ARRAY, [0.0, 0.0]),
)
"""Rights of the mouse in a window."""

SCENE_OBJECT = (
    *_OLD.same("parent parentUid children childOrder selected visible layer modelInvisible modelBase"),
    *_OLD.same("pose position quaternion eulerAngles bbPose model.bbPos model.bbSize"),
    *_OLD.same("collidable measurable detectable objectPropertyFlags ignoreViewFitting collapsed selectable"),
    *_OLD.same("selectModel hideFromModelBB selectInvisible depthInvisible cannotDelete cannotDeleteInSim"),
    *_OLD.same(
        "model.notCollidable model.notMeasurable model.notDetectable model.notDynamic model.notRespondable"
    ),
    *_OLD.same("model.notVisible model.notInParentBB model.scriptsNotActive model.propertyFlags"),
    _OLD.named("alias", "name"),
    _OLD.named("objectUid", "uid"),
    _OLD.named("absPose", "worldPose"),
    _OLD.named("absPosition", "worldPosition"),
    _OLD.named("absQuaternion", "worldQuaternion"),
    _OLD.named("absEulerAngles", "worldEulerAngles"),
    _OLD.named("calcLinearVelocity", "linearVelocity"),
    Property("angularVelocity", t.VECTOR3, _angular_velocity),
    Property("dimension", t.VECTOR3, _size),
    Property("tree", t.HANDLE_ARRAY, _tree),
    Property("persistentUid", t.STRING, _lasting_id),
    Property("modelHash", t.STRING, _model_hash),
    Property("dynamicallyEnabled", t.BOOL, _is_simulated),
    refused("dynamicIcon", t.INT, "it is a sign in a window, and this server has none"),
    refused("dynamicFlag", t.INT, "property 'dynamicallyEnabled' tells whether physics moves an object"),
    kept("hierarchyColor", t.INT, 0),
    kept("modelAcknowledgment", t.STRING, ""),
    kept("collectionSelfCollisionIndicator", t.INT, 0),
    *_MOV,
    refused("dna", t.BUFFER, "objects have no mark that their copies share"),
)
