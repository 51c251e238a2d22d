"""A V-REP file as the server reads it, before anything changed it: what differs from it was changed later."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from simx_server.scene.formats.annotations import PREFIX, Annotations, read_annotations
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.texts.scripts import TEXT_KINDS
from simx_server.scene.formats.vrep.container import Header, unpack
from simx_server.scene.formats.vrep.conversion.context import collection_name
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import VrepFile
from simx_server.scene.formats.vrep.reading import OBJECTS, read_file
from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
from simx_server.scene.formats.vrep.writing.record_lists import RecordList
from simx_server.scene.formats.vrep.writing.top_level import TopRecord, top_records

from .facts import Facts
from .scripts import parse_script, place_of

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.source import VrepSource
    from simx_server.world.world import World


@dataclass(frozen=True)
class Baseline:
    """One file."""

    source: VrepSource
    header: Header
    file: VrepFile
    facts: Facts
    """Of a world that has nothing but this file, whose scripts do not run."""
    annotations: Annotations
    """Those of the file, with its scripts."""
    handles: Mapping[int, int]
    """Numbers of objects in the file, and their handles in that world."""
    records: list[TopRecord]
    """All records of the file."""

    @classmethod
    def of(cls, source: VrepSource, world: World) -> Baseline:
        """Read a file again.

        Args:
            source: the file, which has been read before.
            world: any world; another one of its kind is made.
        """
        header, body = unpack(source.data)
        file = read_file(source.data, source.name)
        spec, _ = convert(file)
        annotations = read_annotations(spec)
        for text in list(spec.texts):
            if text.name.startswith(tuple(f"{PREFIX}{kind}:" for kind in (*TEXT_KINDS, "script"))):
                spec.delete(text)
        other = world.another()
        scene, model = build(spec, None)
        scene.came_from(source)
        other.simulation.use(scene, model, is_logged=False)
        names = other.simulation.scene.by_names()
        handles = {number: names[name] for name, number in source.handles.items() if name in names}
        facts = Facts.of(other, list(other.simulation.scene.objects), is_model=False)
        return cls(source, header, file, facts, annotations, handles, top_records(bytes(body)))

    @cached_property
    def objects(self) -> Mapping[int, tuple[str, bytes]]:
        """Return tag and payload of each object by its number in the file."""
        found: dict[int, tuple[str, bytes]] = {}
        for tag, payload in self.records:
            if tag in OBJECTS:
                found[ObjectRecords.parse(tag, payload, self.header.serialization).handles[0]] = tag, payload
        return found

    @cached_property
    def names(self) -> Mapping[int, str]:
        """Return the names of the objects in that world by their numbers in the file."""
        return {number: name for name, number in self.source.handles.items()}

    @cached_property
    def scripts(self) -> Mapping[int, list[RecordList]]:
        """Return the scripts beside the objects by the object that each one names, -1 for none."""
        found = defaultdict[int, list[RecordList]](list)
        for tag, payload in self.records:
            if tag == "LST":
                script = parse_script(payload, self.header.serialization)
                found[place_of(script)].append(script)
        return dict(found)

    @cached_property
    def numbers(self) -> Mapping[int, int]:
        """Return handles of objects and collections in that world, and their numbers in the file."""
        of_objects = {handle: number for number, handle in self.handles.items()}
        return {**of_objects, **collection_numbers(self.file, self.facts.world)}


def collection_numbers(file: VrepFile, world: World) -> dict[int, int]:
    """Return the handles of collections that a file has, and their numbers there."""
    found: dict[int, int] = {}
    for collection in file.collections:
        handle = world.collections.find(collection_name(collection))
        if handle is not None:
            found[handle] = collection.id
    return found
