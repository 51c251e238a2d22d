"""Write the scene, or a model, as a V-REP file: the file that it comes from, with what has changed since.

Records that the server does not read stay byte by byte. Loaded models bring the records of their files along; objects
that programs have made get new records.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.vrep.conversion.facts.old_call_backs import MAIN
from simx_server.scene.formats.vrep.conversion.facts.scripts import options_of_version
from simx_server.scene.formats.vrep.conversion.geometry.surfaces import Surfaces
from simx_server.scene.formats.vrep.reading import OBJECTS
from simx_server.scene.formats.vrep.writing.meshes import MeshPools
from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list
from simx_server.scene.formats.vrep.writing.top_level import TopRecord, file_bytes

from . import scripts
from .baseline import Baseline, collection_numbers
from .facts import Facts
from .field import NotInVrepFiles, Writing
from .objects import Brought, Origin, records_of
from .registered import ENTRIES, kept_entries, new_entries, number_collections
from .settings import change_settings

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simx_server.scene.formats.vrep.source import VrepSource
    from simx_server.world.world import World

_ORDER = "ORD"
"""Tag of the list of all objects, which the window of the simulator shows."""

_OF_SCENES = ("SIM", "DYN", "ENV", "SET", "VEW", "GHO", _ORDER, "CDA", "CDS", *ENTRIES)
"""Records of a scene that a model has not."""

_OF_MODELS = ("MTC", "BBC")
"""Thumbnail, and size, of another model or scene."""

_FIRST_WITH_POOLS, _FIRST_WITH_SURFACES = 18, 20
"""Versions of the format from which meshes are in common pools, and parameters of contacts in the shapes."""


@dataclass(frozen=True)
class VrepData:
    """The bytes of a file."""

    data: bytes
    has_code_of_client: bool
    """Whether a client sent one of its scripts."""


def vrep_scene(world: World) -> VrepData:
    """Return the scene as a `.ttt` file.

    Raises:
        NotInVrepFiles: the scene was not read from such a file, or has something that is not written into one.
    """
    source = world.origins.scene
    if source is None or source.is_model:
        raise NotInVrepFiles("the whole scene, which was not read from a .ttt file")
    return _Document(world, source, list(world.simulation.scene.objects), is_model=False).data()


def vrep_model(world: World, base: int) -> VrepData:
    """Return an object and all below it as a `.ttm` file. Raises NotInVrepFiles, UnknownHandle."""
    scene = world.simulation.scene
    origin = world.origins.of(scene.get(base).handle)
    if origin is None:
        raise NotInVrepFiles(f"'{scene.get(base).name}', which was not read from a V-REP file")
    return _Document(world, origin[0], [base, *scene.descendants(base)], is_model=True).data()


class _Document:
    """One file in the making."""

    def __init__(self, world: World, source: VrepSource, handles: list[int], *, is_model: bool) -> None:
        self._world, self._handles, self._is_model = world, handles, is_model
        world.clouds.show()
        world.textures.show()
        self._facts = Facts.of(world, handles, is_model=is_model)
        self._baselines: dict[int, Baseline] = {}
        self._first = self._baseline(source)
        self._same_kind = source.is_model == is_model
        version = self._first.header.serialization
        if version < _FIRST_WITH_POOLS:
            raise NotInVrepFiles("a scene of V-REP 3.1 or older, whose format is not written")
        self._numbers = self._numbered()
        records = self._records()
        pools = next((payload for tag, payload in records if tag == "VIN"), END)
        self._pools = MeshPools(parse_list("VIN", pools, version))
        self._writing = Writing(version, self._numbers, pools=self._pools)
        self._writing.surfaces = Surfaces.of_file(self._first.file)
        self._writing.collections = number_collections(
            self._facts, collection_numbers(self._first.file, world) if self._same_kind else {}
        )
        self._writing.free_texture = 1 + max([0, *(_number_of(each) for each in records if each[0] == "TEX")])
        self._others: dict[int, Brought] = {}
        self._top = records
        known = (script for each in self._first.scripts.values() for script in each)
        self._next_script = 1 + max((int((each.numbers("Si2") or [0])[0]) for each in known), default=0)

    def data(self) -> VrepData:
        """Return the file. Raises NotInVrepFiles."""
        version = self._first.header.serialization
        for origin in filter(None, map(self._world.origins.of, self._handles)):
            self._baseline(origin[0])
        known: Mapping[str, Mapping[str, Annotation]] = {}
        if self._same_kind:
            self._top = kept_entries(self._facts, self._first, self._writing)
            known = self._first.facts.saved.registered
        self._top += new_entries(self._facts, known, self._baselines.values(), self._writing, self._top)
        if not self._is_model:
            change_settings(self._top, self._facts, self._first.facts, version)
        scripts_of = {handle: self._scripts(handle) for handle in self._handles}
        self._writing.scripts = {
            handle: [script for _, script in each] for handle, each in scripts_of.items()
        }
        objects = self._objects()
        self._order_siblings(objects)
        for handle, each in scripts_of.items():
            for origin, script in each:
                self._place(handle, origin, script, objects)
        found = self._arranged(objects, scripts_of)
        data = file_bytes(found, self._first.source.data, is_model=self._is_model)
        return VrepData(data, self._facts.saved.has_code_of_client or self._has_scripts_of_client())

    def _has_scripts_of_client(self) -> bool:
        """Return whether a file with scripts came from a client: records of scripts that do not run come along too."""
        is_of_client = self._world.origins.is_of_client
        return any(each.file.scripts and is_of_client(each.source) for each in self._baselines.values())

    # Where objects come from.

    def _baseline(self, source: VrepSource) -> Baseline:
        if id(source) not in self._baselines:
            self._baselines[id(source)] = Baseline.of(source, self._world)
        return self._baselines[id(source)]

    def _numbered(self) -> dict[int, int]:
        """Return the handles of the saved objects and their numbers in the file: those that they have there, if any."""
        found: dict[int, int] = {}
        taken = set[int]()
        for handle in self._handles:
            origin = self._world.origins.of(handle)
            if origin is not None and origin[0] is self._first.source and origin[1] not in taken:
                found[handle] = origin[1]
                taken.add(origin[1])
        free = 1 + max(self._first.source.handles.values(), default=0)
        for handle in self._handles:
            if handle not in found and self._is_written(handle):
                found[handle] = free
                free += 1
        return found

    def _is_written(self, handle: int) -> bool:
        """Return False for an object that the server makes when it reads the file."""
        if self._world.origins.of(handle) is not None:
            return True
        name = self._world.simulation.scene.objects[handle].name
        before = self._first.facts.world.simulation.scene.by_name(name)
        return before is None or before in self._first.handles.values()

    def _origin(self, handle: int) -> Origin | None:
        known = self._world.origins.of(handle)
        if known is None:
            return None
        source, number = known
        if source is self._first.source and self._same_kind:
            return Origin(self._first, number, self._numbers[handle] == number, None)
        baseline = self._baseline(source)
        return Origin(baseline, number, False, self._brought(baseline))

    def _brought(self, baseline: Baseline) -> Brought:
        if id(baseline) not in self._others:
            version = baseline.header.serialization
            if version < _FIRST_WITH_SURFACES and baseline is not self._first:
                raise NotInVrepFiles(f"what comes from '{baseline.source.name}', of V-REP 3.3 or older")
            self._others[id(baseline)] = Brought(baseline, self._writing)
        return self._others[id(baseline)]

    # Parts of the file.

    def _records(self) -> list[TopRecord]:
        """Return the records of the first file that belong into the new one too."""
        if self._same_kind:
            return list(self._first.records)
        dropped = {*_OF_MODELS, *_OF_SCENES, "VIN", "TEX", "LST", *OBJECTS}
        return [each for each in self._first.records if each[0] not in dropped]

    def _objects(self) -> dict[int, ObjectRecords]:
        """Return the records of all objects by their numbers in the file."""
        scene = self._world.simulation.scene
        found: dict[int, ObjectRecords] = {}
        for handle in self._handles:
            if handle in self._numbers:
                records = records_of(self._facts, scene.objects[handle], self._origin(handle), self._writing)
                found[self._numbers[handle]] = records
        return found

    def _order_siblings(self, objects: Mapping[int, ObjectRecords]) -> None:
        """Give the children of an object their places, where one of them has come from another object."""
        scene = self._world.simulation.scene
        for parent in {scene.objects[handle].parent for handle in self._handles if self._has_moved(handle)}:
            for place, child in enumerate(scene.children(parent)):
                if child in self._numbers:
                    objects[self._numbers[child]].common.put_numbers("Cor", place)

    def _has_moved(self, handle: int) -> bool:
        """Return whether an object of the first file has another parent now."""
        if not self._is_first(handle) or self._numbers[handle] not in self._first.objects:
            return False
        parent = self._numbers.get(self._world.simulation.scene.objects[handle].parent, -1)
        return self._first.file.objects[self._numbers[handle]].parent != parent

    def _scripts(self, handle: int) -> list[tuple[RecordList | None, RecordList]]:
        """Return the scripts of an object as they are now, each with the record of its file; None: it is new.

        Raises:
            NotInVrepFiles: a changed one is an old call-back.
        """
        notes = scripts.noted_kinds(self._facts.scripts(handle))
        origin = self._world.origins.of(handle)
        found: list[tuple[RecordList | None, RecordList]] = []
        known: dict[int, Annotation] = {}
        if origin is not None:
            baseline = self._baseline(origin[0])
            name = baseline.names[origin[1]]
            known = scripts.noted_kinds(baseline.annotations.objects.get(name, {}))
            known = {kind: note for kind, note in known.items() if note.get("text")}
            if known and options_of_version(baseline.file.program) != options_of_version(
                self._first.file.program
            ):
                what = f"the script of '{name}', which is of another version than the scene and would run differently"
                raise NotInVrepFiles(what)
            for old in self._scripts_at(baseline, origin[1]):
                kind = (
                    scripts.CUSTOMIZATION if scripts.kind_of(old) == scripts.CUSTOMIZATION else scripts.CHILD
                )
                before, now = known.pop(kind, None), notes.pop(kind, None)
                if before is not None and now is None:
                    continue
                new = RecordList(old.name, old.serialization, list(old))
                if before is not None and now is not None and not scripts.is_same(before, now):
                    scripts.change(new, now, before)
                found.append((old, new))
        for kind, note in notes.items():
            if handle not in self._numbers:
                continue
            number, self._next_script = self._next_script, self._next_script + 1
            owner = self._numbers[handle]
            version = self._writing.serialization
            found.append((None, scripts.new_script(kind, number, owner, note, version)))
        return found

    def _scripts_at(self, baseline: Baseline, number: int) -> list[RecordList]:
        """Return the scripts that lie in an object of a file."""
        tag, payload = baseline.objects[number]
        version = baseline.header.serialization
        if tag == "SCT":
            own = ObjectRecords.parse(tag, payload, version).own
            return [scripts.parse_script(each, version) for each in own.each("Soo")]
        return baseline.scripts.get(number, [])

    def _place(
        self, handle: int, old: RecordList | None, new: RecordList, objects: Mapping[int, ObjectRecords]
    ) -> None:
        """Give a script its owner; put one that lies in a script object there."""
        owner = self._numbers.get(handle)
        if owner is None:
            return
        records = objects[owner]
        if old is not None and scripts.place_of(new) != owner:
            number, self._next_script = self._next_script, self._next_script + 1
            scripts.rename_owner(new, number, owner)
        if records.tag == "SCT":
            records.own.put("Soo", scripts.script_bytes(new))

    def _arranged(
        self,
        objects: Mapping[int, ObjectRecords],
        scripts_of: Mapping[int, list[tuple[RecordList | None, RecordList]]],
    ) -> list[TopRecord]:
        """Return all records of the file in their order."""
        version = self._writing.serialization
        left, handles = dict(objects), {number: handle for handle, number in self._numbers.items()}
        # By the bytes of its record in the file, what has become of a script.
        now = {
            scripts.script_bytes(old): new
            for handle, each in scripts_of.items()
            for old, new in each
            if old is not None and self._is_first(handle) and objects[self._numbers[handle]].tag != "SCT"
        }
        added = [
            ("LST", scripts.script_bytes(new))
            for handle, each in scripts_of.items()
            for old, new in each
            if (old is None or not self._is_first(handle))
            and handle in self._numbers
            and objects[self._numbers[handle]].tag != "SCT"
        ]
        found: list[TopRecord] = []
        for tag, payload in self._top:
            if tag in OBJECTS:
                number = ObjectRecords.parse(tag, payload, version).handles[0]
                if number in left and self._is_first(handles.get(number)):
                    found.append((tag, bytes(left.pop(number))))
            elif tag == "LST":
                script = scripts.parse_script(payload, version)
                if payload in now:
                    found.append((tag, scripts.script_bytes(now[payload])))
                elif scripts.place_of(script) not in self._first.objects:
                    found.append((tag, self._main_script(script, payload)))
            elif tag == "VIN":
                found.append((tag, bytes(self._pools.records) + END))
            else:
                found.append((tag, payload))
        if list(self._pools.records) and not any(tag == "VIN" for tag, _ in found):
            found.insert(0, ("VIN", bytes(self._pools.records) + END))
        textures = [("TEX", _texture(number, pixels, version)) for number, pixels in self._writing.textures]
        place = next((place for place, (tag, _) in enumerate(found) if tag in OBJECTS), len(found))
        found[place:place] = [("TEX", each) for each in self._writing.brought_textures] + textures
        found += [(records.tag, bytes(records)) for records in left.values()] + added
        order = [
            ObjectRecords.parse(tag, payload, version).handles[0] for tag, payload in found if tag in OBJECTS
        ]
        if order != list(self._first.objects):
            numbers = struct.pack(f"<{len(order)}i", *order)
            found = [(tag, numbers if tag == _ORDER else payload) for tag, payload in found]
        return found

    def _main_script(self, script: RecordList, payload: bytes) -> bytes:
        """Return the main script, changed where it was."""
        before, now = self._first.annotations.main_script, self._facts.saved.main_script
        if scripts.kind_of(script) != MAIN or scripts.is_same(before, now):
            return payload
        if now is None:
            raise NotInVrepFiles("the removal of the main script")
        scripts.change(script, now, before or {"text": ""})
        return scripts.script_bytes(script)

    def _is_first(self, handle: int | None) -> bool:
        """Return whether an object has its number and its place in the first file still."""
        if handle is None or not self._same_kind:
            return False
        origin = self._world.origins.of(handle)
        return (
            origin is not None and origin[0] is self._first.source and origin[1] == self._numbers.get(handle)
        )


def _number_of(texture: TopRecord) -> int:
    found = parse_list("TEX", texture[1], 0).numbers("Ipa")
    return int(found[0]) if found else 0


def _texture(number: int, pixels: NDArray[np.uint8], serialization: int) -> bytes:
    """Return the payload of a new texture: (rows, columns, 4), first row at v = 0."""
    rows, columns = pixels.shape[:2]
    found = RecordList("TEX", serialization)
    found.put_numbers("Ipa", number, columns, rows)
    found.put_numbers("Bst", 1)
    found.put("Img", pixels.tobytes())
    return bytes(found) + END
