"""Methods of the scene, and those of the server about scenes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.sim_api.object_model.classes import SCENE_OBJECTS
from simx_server.sim_api.object_model.values import Matrix, Ref
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.tables.objects import kind_word

from .method import Call, Options, handles, method, option, silently, whole, words


def refs(found: Iterable[int]) -> list[Ref]:
    """Return handles as objects."""
    return [Ref(each) for each in found]


def found_object(call: Call, path: str, origin: int | None, options: Options) -> Any:
    """Return the object at a path, from an object on where it starts with a dot; nil with `noError`."""
    api_1: dict[str, Any] = {"noError": bool(option(options, "noError", False))}
    if option(options, "index") is not None:
        api_1["index"] = whole(options, "index", 0)
    if origin is not None:
        api_1["proxy"] = origin
        path = path if path.startswith((".", "/", ":")) else f"./{path}"
    elif path and not path.startswith((".", "/", ":")):
        path = f"/{path}"
    handle = call.sim.getObject(path, api_1)
    return (None if handle == -1 else Ref(handle),)


@method("scene", "getObject", "reads")
def get_object(call: Call, path: str, options: Options = None) -> Any:
    """Return the object of a path such as /Robot/joint; a name without a slash is one from the top."""
    return found_object(call, path, None, options)


@method("sceneObject", "getObject", "reads")
def get_object_below(call: Call, path: str, options: Options = None) -> Any:
    """Return the object of a path that starts at this object."""
    return found_object(call, path, call.handle, options)


def kinds(names: list[str]) -> set[ObjectKind]:
    """Return the kinds of classes of scene objects; all for none, or for sceneObject. Raises CommandError."""
    known = {kind_word(kind): kind for kind in ObjectKind}
    if not names or "sceneObject" in names:
        return set(ObjectKind)
    for word in names:
        if word not in known:
            raise CommandError(
                f"'{word[:40]}' is no class of scene objects; those are {', '.join(SCENE_OBJECTS)}"
            )
    return {known[word] for word in names}


@method("scene", "getObjects", "reads")
def get_objects(call: Call, types: list[str] | None = None) -> list[Ref]:
    """Return the objects of some classes, or all."""
    wanted = kinds(types or [])
    return refs(handle for handle, item in call.world.simulation.scene.objects.items() if item.kind in wanted)


@method("app", "getObjects", "reads")
def get_objects_of_app(call: Call, options: Options = None) -> list[Ref]:
    """Return the objects of the scene; option `types`: of some classes."""
    return get_objects(call, words(options, "types"))


@method("scene", "getDescendants", "reads")
def get_descendants(call: Call, types: list[str] | None = None, depth: int = 9999) -> list[Ref]:
    """Return the objects of some classes down to a depth below the top."""
    return descendants(call, -1, types or [], depth)


def descendants(call: Call, top: int, types: list[str], depth: int) -> list[Ref]:
    """Return the objects below one, parents before their children."""
    scene, wanted = call.world.simulation.scene, kinds(types)
    found: list[int] = []
    waiting = [(handle, 1) for handle in reversed(scene.children(top))]
    while waiting:
        handle, level = waiting.pop()
        if level > depth:
            continue
        found.append(handle)
        waiting += [(child, level + 1) for child in reversed(scene.children(handle))]
    return refs(handle for handle in found if scene.objects[handle].kind in wanted)


@method("scene", "getObjectFromUid", "reads")
def get_object_from_uid(call: Call, uid: int, options: Options = None) -> Any:
    """Return the object with a unique number."""
    return silently(options, lambda: Ref(call.sim.getObjectFromUid(uid)))


@method("scene app", "removeObjects", "changes")
def remove_objects(call: Call, objects: list[Any], options: Options = None) -> None:
    """Remove objects. `delayed` makes no difference: they go when the call is done."""
    silently(options, lambda: call.sim.removeObjects(handles(objects)))


_COPIES = {"models": 1, "noScripts": 2, "noCustomData": 4, "noReferences": 8, "noTextures": 16}


@method("scene", "duplicateObjects", "changes")
def duplicate_objects(call: Call, objects: list[Any], options: Options = None) -> list[Ref]:
    """Copy objects and return the copies; options models, noScripts, noCustomData, noReferences, noTextures."""
    bits = sum(bit for name, bit in _COPIES.items() if option(options, name, False))
    return refs(call.sim.copyPasteObjects(handles(objects), bits))


@method("scene", "groupShapes", "changes")
def group_shapes(call: Call, shapes: list[Any]) -> Ref:
    """Make a compound of shapes."""
    return Ref(call.sim.groupShapes(handles(shapes)))


@method("scene", "mergeShapes", "changes")
def merge_shapes(call: Call, shapes: list[Any]) -> Ref:
    """Make one shape of several."""
    return Ref(call.sim.groupShapes(handles(shapes), True))


@method("scene", "announceChange", "changes")
def announce_change(call: Call) -> None:
    """Tell that the scene has changed."""
    call.sim.announceSceneContentChange()


@method("scene", "loadModel", "changes")
def load_model(call: Call, file: bytes, options: Options = None) -> Any:
    """Load a model; return its base and its text. Options `offset`, a pose by which it is moved; `assemblyDummy` is an
    error.
    """
    if option(options, "assemblyDummy") is not None:
        raise CommandError("assembly is not available: set the parent of the model, and its pose")
    base = call.sim.loadModel(file)
    offset = option(options, "offset")
    if offset is not None:
        moved = call.sim.multiplyPoses(call.sim.getObjectPose(base), t.POSE.convert(offset))
        call.sim.setObjectPose(base, moved)
    return Ref(base), ""


@method("scene", "loadModelFromBuffer", "changes")
def load_model_from_buffer(call: Call, content: bytes, options: Options = None) -> Any:
    """Load a model from the content of a file."""
    return load_model(call, content, options)


@method("app", "loadScene", "changes")
def load_scene(call: Call, file: bytes, _options: Options = None) -> Any:
    """Replace the scene by that of a file; `createNew` makes no difference, since there is one scene."""
    return call.sim.loadScene(file) and None


@method("app", "loadSceneFromBuffer", "changes")
def load_scene_from_buffer(call: Call, content: bytes, _options: Options = None) -> Any:
    """Replace the scene by that of the content of a file."""
    return load_scene(call, content)


@method("scene", "save", "writes files")
def save(call: Call, file: str) -> None:
    """Save the scene in a file of the workspace."""
    call.sim.saveScene(file)


@method("scene", "saveToBuffer", "changes")
def save_to_buffer(call: Call) -> Any:
    """Return the content of a file with the scene."""
    return call.sim.saveScene("")


@method("scene", "remove", "changes")
def remove_scene(call: Call) -> Any:
    """Replace the scene by an empty one: there is always one scene."""
    return call.sim.loadScene(b"") and None


@method("scene", "simulation.start", "changes")
def start(call: Call) -> None:
    """Start the simulation, or go on after a pause."""
    call.sim.startSimulation()


@method("scene", "simulation.stop", "changes")
def stop(call: Call) -> None:
    """Stop the simulation, after the present simulation step."""
    call.sim.stopSimulation()


@method("scene", "simulation.pause", "changes")
def pause(call: Call) -> None:
    """Pause the simulation, after the present simulation step."""
    call.sim.pauseSimulation()


@method("scene", "dynamics.step", "changes")
def step_dynamics(call: Call, seconds: float = 0.0) -> None:
    """Let physics follow: the server makes its steps after the actuation of all scripts."""
    call.sim.handleDynamics(seconds)


@method("scene", "stepKinematicJoints", "changes")
def step_kinematic_joints(call: Call) -> None:
    """Let kinematic joints move: the server moves them after actuation."""
    call.sim.handleJointMotion()


@method("scene", "handleSimulationScripts", "changes")
def handle_simulation_scripts(call: Call, call_type: int) -> int:
    """Call a phase of all simulation scripts, from a main script; return how many have it."""
    return call.sim.handleSimulationScripts(call_type)


@method("scene", "handleCustomizationScripts", "changes")
def handle_customization_scripts(call: Call, call_type: int) -> int:
    """Call a phase of all customization scripts, from a main script; return how many have it."""
    return call.sim.handleCustomizationScripts(call_type)


_CONTACTS_LIMIT = 10_000


def contacts(call: Call, handle: int, options: Options) -> Any:
    """Return pairs of objects that touch, and points, forces and normals as columns of matrices."""
    dynamic_pass = whole(options, "dynPass", -1)
    pairs: list[list[Ref]] = []
    numbers: tuple[list[float], ...] = ([], [], [])
    while len(pairs) < _CONTACTS_LIMIT:
        found = call.sim.getContactInfo(dynamic_pass, handle, len(pairs))
        if found is None:
            break
        pairs.append(refs(found[0]))
        for collected, values in zip(numbers, found[1:], strict=True):
            collected += values[:3]
    return (pairs, *(Matrix.of_points(each, 3) for each in numbers))


@method("scene", "getContacts", "reads")
def get_contacts(call: Call, options: Options = None) -> Any:
    """Return the contacts of the last simulation step; `dynPass`: of one of its physics steps."""
    return contacts(call, c.sim_handle_all, options)


@method("shape", "getContacts", "reads")
def get_contacts_of_shape(call: Call, options: Options = None) -> Any:
    """Return the contacts of a shape, as scene:getContacts does."""
    return contacts(call, call.handle, options)


@method("app", "loadModelInfo", "reads")
def load_model_info(_call: Call, _file: str) -> Any:
    """Refuse: models have no thumbnail here."""
    raise CommandError("models have no image and no text here; load the model and read its properties")


@method("app", "loadModelInfoFromBuffer", "reads")
def load_model_info_from_buffer(call: Call, _content: bytes) -> Any:
    """Refuse: models have no thumbnail here."""
    return load_model_info(call, "")
