"""Methods of all scene objects."""

from __future__ import annotations

from typing import Any

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.object_model.classes import to_api_1
from simx_server.sim_api.object_model.enumerations import number_of
from simx_server.sim_api.object_model.values import Matrix, Pose, Quaternion, Ref, to_color

from .method import Call, Options, method, number, option, silently, text_option, whole, words
from .scene import descendants, refs

_WORLD = -1
_JOINT_BASE = 0x200000
"""sim.handleflag_reljointbaseframe: a pose relative to a joint is one in its fixed frame."""

_FORMS = {"name": -1, "nameOrder": 0, "shortPath": 1, "fullPath": 2, "nameHandle": 4, "printpath": 5, "nameIndex": 6,
          "pathIndex": 7}  # fmt: skip
"""Options of API 1 by forms of a name."""


def _frame(options: Options) -> int:
    """Return the object of the frame that the options name, the world without one."""
    handle = whole(options, "relativeToObject", _WORLD)
    return handle | _JOINT_BASE if handle >= 0 and option(options, "relativeToJointBase", False) else handle


@method("sceneObject", "getPose", "reads")
def get_pose(call: Call, options: Options = None) -> Pose:
    """Return the pose in the world, or in the frame of `relativeToObject`."""
    return Pose(call.sim.getObjectPose(call.handle, _frame(options)))


@method("sceneObject", "getPosition", "reads")
def get_position(call: Call, options: Options = None) -> Matrix:
    """Return the position, as getPose does the pose."""
    return Matrix.vector(call.sim.getObjectPosition(call.handle, _frame(options)))


@method("sceneObject", "getQuaternion", "reads")
def get_quaternion(call: Call, options: Options = None) -> Quaternion:
    """Return the quaternion, as getPose does the pose."""
    return Quaternion(call.sim.getObjectQuaternion(call.handle, _frame(options)))


@method("sceneObject", "setPose", "changes")
def set_pose(call: Call, pose: list[float], options: Options = None) -> None:
    """Set the pose in the world, or in the frame of `relativeToObject`."""
    call.sim.setObjectPose(call.handle, _frame(options), pose)


@method("sceneObject", "setPosition", "changes")
def set_position(call: Call, position: list[float], options: Options = None) -> None:
    """Set the position, as setPose does the pose."""
    call.sim.setObjectPosition(call.handle, _frame(options), position)


@method("sceneObject", "setQuaternion", "changes")
def set_quaternion(call: Call, quaternion: list[float], options: Options = None) -> None:
    """Set the quaternion, as setPose does the pose."""
    call.sim.setObjectQuaternion(call.handle, _frame(options), quaternion)


@method("sceneObject", "setParent", "changes")
def set_parent(call: Call, parent: int | None = None, options: Options = None) -> None:
    """Set the parent; nil moves the object to the top. `mode`: an item of parentingMode, keepWorldPose at first."""
    mode = option(options, "mode", 1)
    if isinstance(mode, bytes):
        mode = mode.decode("utf-8", "replace")
    number = number_of("parentingMode", mode)
    if number == number_of("parentingMode", "assembly"):
        raise CommandError("assembly is not available; use keepWorldPose or keepLocalPose")
    call.sim.setObjectParent(call.handle, -1 if parent is None else parent, number == 1)


@method("sceneObject", "getName", "reads")
def get_name(call: Call, form: str = "name") -> str:
    """Return the name in a form: name, nameOrder, shortPath, fullPath, nameHandle, printpath, nameIndex, pathIndex."""
    if form not in _FORMS:
        raise CommandError(f"'{form[:40]}' is no form of a name; those are {', '.join(_FORMS)}")
    return call.sim.getObjectAlias(call.handle, _FORMS[form])


@method("sceneObject", "getDescendants", "reads")
def get_descendants(call: Call, options: Options = None) -> list[Ref]:
    """Return the objects below this one; options `types` and `depth`."""
    return descendants(call, call.handle, words(options, "types"), whole(options, "depth", 9999))


@method("sceneObject", "getAncestors", "reads")
def get_ancestors(call: Call, options: Options = None) -> list[Ref]:
    """Return the objects above this one, its parent first; option `depth`."""
    scene, found = call.world.simulation.scene, list[int]()
    parent = scene.get(call.handle).parent
    while parent != -1 and len(found) < whole(options, "depth", 9999):
        found.append(parent)
        parent = scene.get(parent).parent
    return refs(found)


@method("sceneObject", "visitTree", "reads")
def visit_tree(call: Call, visitor: Function, options: Options = None) -> None:
    """Call a function with this object and all below it; where it returns false, those below are left out."""

    def visit(*arguments: Any) -> list[Any]:
        return visitor(*(Ref(handle) for handle in arguments))

    call.sim.visitTree(call.handle, visit, options)


@method("sceneObject", "remove", "changes")
def remove(call: Call, options: Options = None) -> None:
    """Remove this object."""
    silently(options, lambda: call.sim.removeObjects([call.handle]))


@method("sceneObject", "removeModel", "changes")
def remove_model(call: Call, options: Options = None) -> None:
    """Remove the model whose base this is."""
    silently(options, lambda: call.sim.removeModel(call.handle) and None)


@method("sceneObject", "saveModel", "writes files")
def save_model(call: Call, file: str) -> None:
    """Save the model whose base this is in a file of the workspace."""
    call.sim.saveModel(call.handle, file)


@method("sceneObject", "saveModelToBuffer", "changes")
def save_model_to_buffer(call: Call) -> Any:
    """Return the content of a file with the model."""
    return call.sim.saveModel(call.handle)


def _entity(handle: int) -> int:
    return c.sim_handle_all if handle == c.sim_handle_all else to_api_1(handle)


@method("sceneObject collection", "checkCollision", "reads")
def check_collision(call: Call, entity: int = c.sim_handle_all) -> Any:
    """Return whether this and another entity, or everything else, collide now, and a pair of objects that do."""
    hit, pair = call.sim.checkCollision(call.old, _entity(entity))
    return bool(hit), refs(pair)


@method("sceneObject collection", "checkDistance", "reads")
def check_distance(call: Call, entity: int = c.sim_handle_all, options: Options = None) -> Any:
    """Return whether another entity is nearer than `threshold`, the distance, a point on each, and the objects."""
    near, numbers, pair = call.sim.checkDistance(call.old, _entity(entity), number(options, "threshold", 0.0))
    return bool(near), numbers[6], Matrix.vector(numbers[:3]), Matrix.vector(numbers[3:6]), refs(pair)


@method("sceneObject", "dynamicReset", "changes")
def dynamic_reset(call: Call, _options: Options = None) -> None:
    """Set the velocity of this object and of all below it to 0, as if the option `tree` were true."""
    call.sim.resetDynamicObject(call.handle)


@method("sceneObject", "scale", "changes")
def scale(call: Call, factors: list[float]) -> None:
    """Scale this object along its axes."""
    if len(factors) != 3:
        raise CommandError(f"the factors are three numbers, not {len(factors)}")
    call.sim.scaleObject(call.handle, factors[0], factors[1], factors[2])


@method("sceneObject", "scaleTree", "changes")
def scale_tree(call: Call, factor: float, options: Options = None) -> None:
    """Scale this object and all below it; option `scalePositions`: also their places, true at first."""
    below = [call.handle, *call.world.simulation.scene.descendants(call.handle)]
    call.sim.scaleObjects(below, factor, bool(option(options, "scalePositions", True)))


@method("sceneObject collection", "changeColor", "changes", takes_values=True)
def change_color(call: Call, color: Any, options: Options = None) -> list[Any]:
    """Set a colour of a shape, or of all shapes of a collection; return what restoreColor needs."""
    word = text_option(options, "component", "diffuse")
    try:
        parts = to_color(color).parts
    except TypeError as problem:
        raise CommandError(f"argument 1 must be {problem}") from None
    return call.sim.changeEntityColor(call.old, parts, number_of("materialComponent", word))


@method("sceneObject collection", "restoreColor", "changes")
def restore_color(call: Call, before: list[Any]) -> None:
    """Give the colours back that changeColor has replaced."""
    call.sim.restoreEntityColor(before)


@method("collection", "addItem", "changes")
def add_item(call: Call, item: int, options: Options = None) -> None:
    """Add an object; options `mode` (sim.handle_single, tree, chain, all) and `excludeObject`: without itself."""
    _change(call, item, options, bits=0)


@method("collection", "removeItem", "changes")
def remove_item(call: Call, item: int, options: Options = None) -> None:
    """Take an object out; options as of addItem."""
    _change(call, item, options, bits=1)


def _change(call: Call, item: int, options: Options, bits: int) -> None:
    mode = whole(options, "mode", c.sim_handle_all if item == c.sim_handle_all else c.sim_handle_single)
    bits |= 2 if option(options, "excludeObject", False) else 0
    call.sim.addItemToCollection(call.old, mode, item, bits)


@method("collection", "remove", "changes")
def remove_collection(call: Call, options: Options = None) -> None:
    """Remove this collection."""
    silently(options, lambda: call.sim.destroyCollection(call.old) and None)
