"""Objects of the scene: finding, creating, copying and removing them; their kinds and parents."""

from __future__ import annotations

import re
from typing import Annotated, Any

from simx_client.protocol import constants as c
from simx_server.editing.copying import Kept, copy_objects
from simx_server.errors import CommandError, UnknownName
from simx_server.handlers.objects import objects
from simx_server.handlers.scene_files import script_files
from simx_server.scripting.conversion.signature import Most, describe, to_int
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.base import HANDLE_SELF, ApiPart
from simx_server.sim_api.effects import reads

_SILENT = "@silenterror"
_SCENE = -12
"""`sim_handle_scene`: in place of an object, everything."""

_WITHOUT_BASE, _CHILDREN_ONLY = 1, 2

_UIDS_PER_SCENE = 1_000_000
"""Greater than the number of handles that a scene ever uses."""

_FAINT = (0, 0, 0, 64, 64, 64, 0, 0, 0)
"""Default values after the RGB of a dummy's colour: reserved, specular, emission."""

_SCRIPT = re.compile(r"(?P<owner>[/.].*?|)/[Ss]cript(?:\[(?P<index>\d{1,6})\]|\{(?P<among_all>\d{1,6})\})?")
"""A path to a script of an object."""


class ObjectFunctions(ApiPart, effect="changes"):
    """Functions for handles, kinds and parents."""

    @reads
    def getObjectHandle(self, name: str, options: dict[str, Any] | None = None) -> int:
        """Return the handle as getObject does. An unknown name is an error; with ``name@silentError`` it returns -1."""
        return self.getObject(name, options)

    @reads
    def getObject(self, path: str, options: dict[str, Any] | None = None) -> int:
        """Return the handle of an object by path or old name. ``./`` starts at the script's object; in a copied
        script, names mean the copied objects.

        ``PATH/Script`` is the script of an object. Options: `index`, from 0, selects one of several matches; `proxy`
        is the object at which ``./`` starts; `noError` returns -1 instead of an error.
        """
        if path == str(HANDLE_SELF):
            # In V-REP 3 a script gets its own object by sim.getObjectHandle(sim.handle_self).
            return self._owner
        asked = options or {}
        text = self._adjusted(path)
        if "index" in asked:
            text = f"{text}{{{_number(asked, 'index')}}}"
        origin = self._self(_number(asked, "proxy")) if "proxy" in asked else self._owner
        try:
            return self._sim.scene.resolve(text, origin)
        except UnknownName:
            if (script := self._script_of_path(text, origin)) != -1:
                return script
            if asked.get("noError") or path.lower().endswith(_SILENT):
                return -1
            raise

    def _script_of_path(self, text: str, origin: int) -> int:
        """Return the script that ``PATH/Script`` or ``PATH/Script[1]`` means, -1 for none.

        Since CoppeliaSim 4.7 scripts are objects of this alias below the one that they serve.
        """
        match = _SCRIPT.fullmatch(text)
        if match is None:
            return -1
        try:
            owner = self._sim.scene.resolve(match["owner"] or ".", origin)
        except UnknownName:
            return -1
        its_own = [each.handle for each in self._world.scripts.all() if each.owner == owner]
        index = int(match["index"] or match["among_all"] or 0)
        return its_own[index] if index < len(its_own) else -1

    @reads
    def getObjectFromUid(self, uid: int, options: dict[str, Any] | None = None) -> int:
        """Return the object with this identifier. Option `noError`: -1 instead of an error."""
        scene, handle = divmod(uid, _UIDS_PER_SCENE)
        if scene == self._sim.scene_id and handle in self._sim.scene.objects:
            return handle
        if options and options.get("noError"):
            return -1
        raise CommandError(f"no object of this scene has the identifier {uid}")

    @reads
    def getObjectUid(self, handle: int) -> int:
        """Return a number that is unique to the object until the server exits."""
        return self._sim.scene_id * _UIDS_PER_SCENE + self._sim.scene.get(self._self(handle)).handle

    @reads
    def getObjectUniqueIdentifier(self, handle: int) -> int | list[int]:
        """Return the number of getObjectUid; with sim.handle_all a table with those of all objects."""
        if handle == c.sim_handle_all:
            return [self.getObjectUid(each) for each in self._sim.scene.objects]
        return self.getObjectUid(handle)

    @reads
    def isHandle(self, handle: int) -> bool:
        """Return whether an object or a collection has this handle."""
        return self._self(handle) in self._sim.scene.objects or handle in self._world.collections

    @reads
    def isHandleValid(self, handle: int, kind: int = -1) -> int:
        """Return 1 if the handle is valid, else 0. `kind`: sim.appobj_object_type, sim.appobj_collection_type, ...,
        or -1 for any of them.
        """
        known = {
            c.sim_appobj_object_type: self._sim.scene.objects,
            c.sim_appobj_collection_type: self._world.collections,
            c.sim_appobj_collision_type: self._world.meters.collisions.handles(explicit_too=True),
            c.sim_appobj_distance_type: self._world.meters.distances.handles(explicit_too=True),
        }
        if kind != -1 and kind not in known:
            raise CommandError(f"a kind of handle is -1 or one of {sorted(known)}, not {kind}")
        handle = self._self(handle)
        return int(any(handle in handles for each, handles in known.items() if kind in (-1, each)))

    @reads
    def getObjectType(self, handle: int) -> int:
        """Return sim.object_shape_type, sim.object_joint_type, ..."""
        return int(self._sim.scene.get(self._self(handle)).kind)

    @reads
    def getObjects(self, index: int, kind: int = c.sim_handle_all) -> int:
        """Return the object at this index, from 0, among all or those of one kind; -1 after the last."""
        return _at(objects.get_objects(self._world, kind), index)

    @reads
    def getObjectsInTree(self, base: int, kind: int = c.sim_handle_all, options: int = 0) -> list[int]:
        """Return an object and all below it, or with sim.handle_scene everything; depth first.

        Options: 1 without the object itself, 2 only its direct children.
        """
        scene = self._sim.scene
        top = -1 if base == _SCENE else scene.get(self._self(base)).handle
        found = scene.children(top) if options & _CHILDREN_ONLY else scene.descendants(top)
        if top != -1 and not options & _WITHOUT_BASE:
            found = [top, *found]
        if kind == c.sim_handle_all:
            return found
        return [each for each in found if scene.objects[each].kind == kind]

    @reads
    def visitTree(self, root: int, visitor: Function | str, options: dict[str, Any] | None = None) -> None:
        """Call a function with the handle of an object and of all below it; with sim.handle_scene of all objects.

        An object comes before its children, which are left out where the function returns false; with the option
        `post` it comes after them, with `pre` and `post` both.
        """
        chosen = options or {}
        after = bool(chosen.get("post"))
        before = bool(chosen.get("pre", not after))
        self._visit(-1 if root == _SCENE else self._self(root), self._function(visitor), before, after)

    def _visit(self, top: int, visitor: Function, before: bool, after: bool) -> None:
        """Visit a tree without recursion: it may be deep."""
        scene = self._sim.scene
        pending = [(handle, False) for handle in reversed([top] if top != -1 else scene.children(-1))]
        while pending:
            handle, is_left = pending.pop()
            self._sim.scene.get(handle)
            if is_left:
                visitor(handle)
                continue
            if before and visitor(handle)[:1] == [False]:
                continue
            if after:
                pending.append((handle, True))
            scene = self._sim.scene
            children = scene.children(handle) if handle in scene.objects else []
            pending += [(child, False) for child in reversed(children)]

    @reads
    def getObjectChild(self, handle: int, index: int) -> int:
        """Return the child at this index, from 0; -1 after the last child."""
        return _at(self._sim.scene.children(self._sim.scene.get(self._self(handle)).handle), index)

    @reads
    def getObjectParent(self, handle: int) -> int:
        """Return the parent; -1 at the top of the tree."""
        return self._sim.scene.get(self._self(handle)).parent

    def setObjectParent(self, handle: int, parent: int, keep_in_place: bool = True) -> int:
        """Set the parent; -1 moves the object to the top of the tree."""
        objects.set_object_parent(self._world, self._self(handle), self._self(parent), keep_in_place)
        return 1

    def createDummy(self, size: float, color: list[float] | None = None) -> int:
        """Create a dummy at the origin, its size in metres, and return its handle. Colour: RGB 0..1, or 12 numbers:
        RGB of ambient and diffuse, reserved, specular, emission.
        """
        numbers = [round(value * 255) for value in color or []]
        if len(numbers) not in (0, 3, 12):
            raise CommandError(f"a colour is 3 or 12 numbers, not {len(numbers)}")
        return objects.create_dummy(
            self._world, size, [*numbers, *_FAINT] if len(numbers) == 3 else numbers or None
        )

    def copyPasteObjects(self, handles: Annotated[list[int], Most(100_000)], options: int = 0) -> list[int]:
        """Copy objects and return the copies, of a whole model its base. Copies made during a run are removed at its
        stop. Options: 1 model bases with all below them, 2 without scripts, 4 without custom data, 8 without
        references, 16 without textures.
        """
        kept = Kept(
            models=bool(options & 1),
            scripts=not options & 2,
            data=not options & 4,
            references=not options & 8,
            textures=not options & 16,
        )
        return copy_objects(self._world, [self._self(handle) for handle in handles], kept)

    def copyPasteSelectedObjects(self, whole_models: bool = True) -> int:
        """Copy the selected objects, and select the copies; return 1. V-REP 2's form of sim.copyPasteObjects."""
        self._world.selection.handles = self.copyPasteObjects(
            self._world.selection.handles, int(whole_models)
        )
        return 1

    def removeObject(self, handle: int) -> int:
        """Remove an object, but not its children; sim.handle_all empties the scene. Objects removed during a run
        return at its stop.
        """
        objects.remove_object(self._world, self._self(handle))
        return 1

    def removeObjects(self, handles: list[int], _delayed: bool = False) -> None:
        for handle in handles:
            self.removeObject(handle)

    def removeModel(self, base: int, _delayed: bool = False) -> int:
        """Remove a model base with all below it; return the number of removed objects."""
        before = len(self._sim.scene.objects)
        objects.remove_model(self._world, self._self(base))
        return before - len(self._sim.scene.objects)

    def loadModel(self, file: bytes) -> int:
        """Load a model, select its base and return it.

        The argument is a file of the server's workspace or of the files that come with the server, `.ttm`, MJCF, URDF
        or a mesh, or the content of a `.ttm` file.
        """
        return script_files.load_model_of_server(self._world, file)

    @reads
    def getModelProperty(self, handle: int) -> int:
        """Return bits of a model base; sim.modelproperty_not_model for any other object."""
        return objects.get_model_property(self._world, self._self(handle))

    def setModelProperty(self, handle: int, bits: int) -> int:
        objects.set_model_property(self._world, self._self(handle), bits)
        return 1


def _number(options: dict[str, Any], name: str) -> int:
    try:
        return to_int(options[name])
    except TypeError as problem:
        raise CommandError(f"the option '{name}' must be {problem}, got {describe(options[name])}") from None


def _at(handles: list[int], index: int) -> int:
    return handles[index] if 0 <= index < len(handles) else -1
