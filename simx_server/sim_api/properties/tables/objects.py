"""Properties of all objects: names, the tree, flags, and what a model base says of its model."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

from simx_client.protocol import constants as c
from simx_server.editing import object_flags
from simx_server.editing.sibling_order import move_among_siblings, place_among_siblings
from simx_server.errors import CommandError
from simx_server.handlers.objects import objects
from simx_server.scene.editing import renaming
from simx_server.scene.objects import NOT_A_MODEL, ObjectKind
from simx_server.scene.properties import SCRIPTS_INACTIVE
from simx_server.sim_api.properties.entry import Property, bit_of, numbered, renamed
from simx_server.sim_api.properties.property_types import BOOL, HANDLE, HANDLE_ARRAY, INT, LONG, STRING

if TYPE_CHECKING:
    from simx_server.scene.objects import Scene
    from simx_server.world.world import World

_UIDS_PER_SCENE = 1_000_000
"""As of sim.getObjectUid."""

_NOT_IN_PARENT_BOX = 0x400

_KIND_WORDS = {"octree": "ocTree"}
"""Kinds whose word in CoppeliaSim is not that of the server in camel case."""


def _scene(world: World) -> Scene:
    return world.simulation.scene


@cache
def kind_word(kind: ObjectKind) -> str:
    """Return CoppeliaSim's word for a kind of object, such as visionSensor."""
    first, *rest = kind.name.lower().split("_")
    word = first + "".join(each.capitalize() for each in rest)
    return _KIND_WORDS.get(word, word)


def _uid(world: World, handle: int) -> int:
    return -1 if handle == -1 else world.simulation.scene_id * _UIDS_PER_SCENE + handle


def _select(world: World, handle: int, selected: bool) -> None:
    others = [each for each in objects.get_object_selection(world) if each != handle]
    objects.set_object_selection(world, [*others, handle] if selected else others)


_PARENT = Property(
    "parent",
    HANDLE,
    lambda world, handle: _scene(world).get(handle).parent,
    lambda world, handle, parent: objects.set_object_parent(world, handle, parent, True),
)

_TREE = (
    Property("handle", HANDLE, lambda _world, handle: handle),
    Property("objectType", STRING, lambda world, handle: kind_word(_scene(world).get(handle).kind)),
    Property("objectUid", LONG, _uid),
    Property(
        "alias",
        STRING,
        lambda world, handle: _scene(world).get(handle).alias,
        lambda world, handle, alias: renaming.set_alias(world.simulation, handle, alias),
    ),
    Property(
        "deprecatedName",
        STRING,
        lambda world, handle: _scene(world).get(handle).name,
        lambda world, handle, name: renaming.rename(world.simulation, handle, name),
    ),
    _PARENT,
    renamed(_PARENT, "parentHandle", INT),
    Property("parentUid", LONG, lambda world, handle: _uid(world, _scene(world).get(handle).parent)),
    Property("children", HANDLE_ARRAY, lambda world, handle: _scene(world).children(handle)),
    Property(
        "childOrder",
        INT,
        lambda world, handle: place_among_siblings(world.simulation, handle),
        lambda world, handle, place: move_among_siblings(world.simulation, handle, place),
    ),
    Property("selected", BOOL, lambda world, handle: handle in objects.get_object_selection(world), _select),
)

_VISIBILITY = (
    numbered("visible", BOOL, "objintparam_visible"),
    numbered("layer", INT, "objintparam_visibility_layer"),
    Property(
        "modelInvisible",
        BOOL,
        lambda world, handle: bool(_scene(world).overridden(handle) & c.sim_modelproperty_not_visible),
    ),
)

_SPECIAL = Property("", INT, object_flags.special_flags, object_flags.set_special_flags)

_ABILITIES = (
    bit_of(_SPECIAL, "collidable", c.sim_objectspecialproperty_collidable),
    bit_of(_SPECIAL, "measurable", c.sim_objectspecialproperty_measurable),
    bit_of(_SPECIAL, "detectable", c.sim_objectspecialproperty_detectable_all),
)

_FLAGS = Property("objectPropertyFlags", INT, object_flags.flags, object_flags.set_flags)

_VIEWERS = (
    _FLAGS,
    bit_of(_FLAGS, "ignoreViewFitting", 0x1),
    bit_of(_FLAGS, "collapsed", 0x10),
    bit_of(_FLAGS, "selectable", 0x20),
    bit_of(_FLAGS, "selectModel", 0x80),
    bit_of(_FLAGS, "hideFromModelBB", 0x100),
    bit_of(_FLAGS, "selectInvisible", 0x800),
    bit_of(_FLAGS, "depthInvisible", 0x1000),
    bit_of(_FLAGS, "cannotDelete", 0x2000),
    bit_of(_FLAGS, "cannotDeleteInSim", 0x4000),
)
"""Bits that are stored, as by sim.setObjectProperty; only bounding boxes of models depend on one of them."""


def _is_base(world: World, handle: int) -> bool:
    return _scene(world).is_model_base(handle)


def _make_base(world: World, handle: int, is_base: bool) -> None:
    if is_base != _is_base(world, handle):
        objects.set_model_property(world, handle, 0 if is_base else NOT_A_MODEL)


def _model_flags(world: World, handle: int) -> int:
    bits = _scene(world).model_property(handle)
    return 0 if bits & NOT_A_MODEL else bits


def _set_model_flags(world: World, handle: int, bits: int) -> None:
    if not _is_base(world, handle):
        name = _scene(world).get(handle).name
        raise CommandError(f"'{name}' is no model base; set its property 'modelBase' first")
    objects.set_model_property(world, handle, bits)


_MODEL_FLAGS = Property("modelPropertyFlags", INT, _model_flags, _set_model_flags)

_MODEL_BITS = {
    "Collidable": c.sim_modelproperty_not_collidable,
    "Measurable": c.sim_modelproperty_not_measurable,
    "Detectable": c.sim_modelproperty_not_detectable,
    "Dynamic": c.sim_modelproperty_not_dynamic,
    "Respondable": c.sim_modelproperty_not_respondable,
    "Visible": c.sim_modelproperty_not_visible,
    "InParentBB": _NOT_IN_PARENT_BOX,
}


def _of_models(name: Callable[[str], str]) -> list[Property]:
    """Return the properties of a model; `name` makes the name of one in a version of CoppeliaSim."""
    return [
        renamed(_MODEL_FLAGS, name("PropertyFlags")),
        *(bit_of(_MODEL_FLAGS, name(f"Not{word}"), bit) for word, bit in _MODEL_BITS.items()),
        bit_of(_MODEL_FLAGS, name("ScriptsNotActive"), SCRIPTS_INACTIVE),
    ]


_MODELS = (
    Property("modelBase", BOOL, _is_base, _make_base),
    *_of_models(lambda word: f"model{word}"),
    *_of_models(lambda word: f"model.{word[0].lower()}{word[1:]}"),
)
"""CoppeliaSim 4.8 writes modelNotVisible, 4.10 model.notVisible."""

OBJECTS = (*_TREE, *_VISIBILITY, *_ABILITIES, *_VIEWERS, *_MODELS)
