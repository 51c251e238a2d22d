"""Data that scripts store with objects, the scene or the server: bytes by name, see `custom_data.py` of the server."""

from __future__ import annotations

import re
from typing import Annotated, Any

from simx_server.errors import CommandError
from simx_server.handlers.objects import objects
from simx_server.parts.custom_data import (
    APPLICATION,
    EXTENSION,
    HIDDEN,
    NUMBERED,
    PART_EXTENSION,
    REFERENCES,
    SCENE,
)
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.conversion.signature import Most
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.values.packing import pack, unpack
from simx_server.sim_api.values.tables import pack_table, unpack_table

_PERSISTENT = HIDDEN + "persistent/"
"""Prefixes of the names under which these are stored."""

_PATTERN = re.compile(r"\^?(?:\\.|\.\*|\.|[^][\\^$.|?*+(){}])*\$?")
_LONGEST_PATTERN = 1000

_ESCAPED = re.compile(r"\\(.)")

_MOST_REPEATS = 3
"""Repetitions in a pattern: the time of a search grows with the length of a name to this power."""


def _compiled(pattern: str) -> re.Pattern[str]:
    if not _PATTERN.fullmatch(pattern) or pattern.count("*") > _MOST_REPEATS:
        raise CommandError(
            f"'{pattern[:80]}' is not a pattern of characters, '.', up to {_MOST_REPEATS} '.*', '^' at its start, "
            "'$' at its end and '\\' before a character that means itself"
        )
    return re.compile(_ESCAPED.sub(lambda found: re.escape(found[1]), pattern))


class CustomDataFunctions(ApiPart, effect="changes"):
    """Data of an object, sim.handle_scene or sim.handle_app. Missing data is read as nil."""

    def writeCustomDataBlock(self, handle: int, name: str, data: bytes | None = None) -> int:
        """Write a block; '' or nil removes it, an empty name removes all blocks. Blocks named @tmp... end with the
        run.
        """
        self._world.custom_data.write(self._self(handle), name, data or b"")
        return 1

    @reads
    def readCustomDataBlock(self, handle: int, name: str) -> bytes | None:
        return self._world.custom_data.read(self._self(handle), name)

    @reads
    def readCustomDataBlockTags(self, handle: int) -> list[str] | None:
        """Return the names of all blocks; nil when there are none."""
        names = self._world.custom_data.names(self._self(handle))
        return [name for name in names if not name.startswith(HIDDEN)] or None

    readCustomDataTags = readCustomDataBlockTags
    writeCustomStringData = writeCustomDataBlock
    readCustomStringData = readCustomDataBlock
    writeCustomBufferData = writeCustomDataBlock
    readCustomBufferData = readCustomDataBlock

    def addObjectCustomData(self, handle: int, header: int, data: bytes, _length: int = 0) -> int:
        """Write the data of a number, V-REP 3's form of blocks; '' removes them. Return 1.

        Partly: numbered data of files are not read.
        """
        self._world.custom_data.write(self._self(handle), f"{NUMBERED}{header}", data)
        return 1

    @reads
    def getObjectCustomData(self, handle: int, header: int) -> bytes:
        """Return the data of a number, '' when there are none."""
        return self._world.custom_data.read(self._self(handle), f"{NUMBERED}{header}") or b""

    def addSceneCustomData(self, header: int, data: bytes, _length: int = 0) -> int:
        """Write the scene's data of a number as sim.addObjectCustomData does."""
        return self.addObjectCustomData(SCENE, header, data)

    @reads
    def getSceneCustomData(self, header: int) -> bytes:
        """Return the scene's data of a number, '' when there are none."""
        return self.getObjectCustomData(SCENE, header)

    def writeCustomTableData(
        self, handle: int, name: str, table: list[Any] | dict[Any, Any] | None = None
    ) -> None:
        """Write a table as `packTable` packs it; an empty table removes the block."""
        packed = pack_table(table) if table else b""
        self.writeCustomDataBlock(handle, name, packed)

    @reads
    def readCustomTableData(self, handle: int, name: str) -> Any:
        """Return the table with this name; an empty one when it does not exist."""
        packed = self.readCustomDataBlock(handle, name)
        return unpack_table(packed) if packed else []

    def persistentDataWrite(self, name: str, data: bytes, options: int = 0) -> int:
        """Store data in the server until it exits; '' removes it.

        Partly: nothing is written to disk, whatever the options.
        """
        self._world.custom_data.write(APPLICATION, f"{_PERSISTENT}{name}", data)
        return 1

    def persistentDataRead(self, name: str) -> bytes | None:
        return self._world.custom_data.read(APPLICATION, f"{_PERSISTENT}{name}")

    @reads
    def getPersistentDataTags(self) -> list[str]:
        names = self._world.custom_data.names(APPLICATION)
        return [name.removeprefix(_PERSISTENT) for name in names if name.startswith(_PERSISTENT)]

    @reads
    def getMatchingPersistentDataTags(self, pattern: Annotated[str, Most(_LONGEST_PATTERN)]) -> list[str]:
        """Return the names of stored data in which a pattern occurs: characters, ``.`` for any character, ``.*`` for
        any number of them, ``^`` and ``$`` for start and end, ``\\`` before a character that means itself.

        Partly: other operators of regular expressions are errors, and so are more than three ``.*``.
        """
        wanted = _compiled(pattern)
        return [name for name in self.getPersistentDataTags() if wanted.search(name)]

    def setReferencedHandles(self, handle: int, handles: list[int] | None = None, tag: str = "") -> int:
        """Store references from one object to other objects, per tag. References to objects that are copied with it
        mean the copies.
        """
        packed = pack("i", [float(each) for each in handles or []], 0, 0)
        self._world.custom_data.write(self._self(handle), f"{REFERENCES}{tag}", packed)
        return 1

    @reads
    def getReferencedHandlesTags(self, handle: int) -> list[str]:
        """Return the tags under which an object has references."""
        names = self._world.custom_data.names(self._self(handle))
        return [name.removeprefix(REFERENCES) for name in names if name.startswith(REFERENCES)]

    @reads
    def getReferencedHandles(self, handle: int, tag: str = "") -> list[int]:
        """Return the referenced objects; -1 stands for removed ones."""
        packed = self._world.custom_data.read(self._self(handle), f"{REFERENCES}{tag}") or b""
        return [
            each if each in self._sim.scene.objects else -1 for each in unpack("i", packed, 0, 0, 0) or []
        ]

    @reads
    def getReferencedHandle(self, handle: int, tag: str = "") -> int:
        """Return the only referenced object of a tag."""
        found = self.getReferencedHandles(handle, tag)
        if len(found) != 1:
            raise CommandError(f"'{tag[:80]}' refers to {len(found)} objects, not to one")
        return found[0]

    def addReferencedHandle(
        self,
        handle: int,
        referenced: int,
        tag: str | dict[str, Any] = "",
        options: dict[str, Any] | None = None,
    ) -> None:
        """Add a reference. With the option `wholeTree` also to all objects below the referenced one."""
        if isinstance(tag, dict):
            tag, options = "", tag
        base = self._sim.scene.get(self._self(referenced)).handle
        below = self._sim.scene.descendants(base) if (options or {}).get("wholeTree") else []
        self.setReferencedHandles(handle, [*self.getReferencedHandles(handle, tag), base, *below], tag)

    def removeReferencedObjects(self, handle: int, tag: str = "") -> None:
        """Remove the referenced objects from the scene, models with all below them, and the references."""
        for each in self.getReferencedHandles(handle, tag):
            if each not in self._sim.scene.objects:
                continue  # removed, or part of a model that is removed
            if self._sim.scene.is_model_base(each):
                objects.remove_model(self._world, each)
            else:
                objects.remove_object(self._world, each)
        self.setReferencedHandles(handle, [], tag)

    def setExtensionString(self, handle: int, index: int, text: bytes) -> None:
        """Set V-REP's extension string, ``plugin {name {value}}`` ...; '' removes it. `handle`, `index`: as in
        sim.getExtensionString.
        """
        self._world.custom_data.write(*self._extension(handle, index), text)

    @reads
    def getExtensionString(self, handle: int, index: int, key: str | None = None) -> bytes | None:
        """Return the extension string of an object (`index` -1), of a part of a shape (from 0) or of the scene (handle
        -1); nil when there is none. With a key ``name@plugin`` return the text in braces after it, or after the name in
        the braces of the plug-in.
        """
        text = self._world.custom_data.read(*self._extension(handle, index))
        if text is None or not key:
            return text
        if (found := _value_of(text, key.encode())) is not None:
            return found
        for name in reversed(key.encode().split(b"@")):
            text = _value_of(text, name) if text else None
        return text or None

    def _extension(self, handle: int, index: int) -> tuple[int, str]:
        """Return whose text is meant, and its name. Raises UnknownHandle."""
        if handle == -1:
            return SCENE, EXTENSION
        item = self._sim.scene.get(self._self(handle))
        is_part = item.kind == ObjectKind.SHAPE and index >= 0
        return item.handle, f"{PART_EXTENSION}{index}" if is_part else EXTENSION


def _value_of(text: bytes, key: bytes) -> bytes | None:
    """Return the text in the braces after a key; a key within other braces does not count."""
    depth = start = opening = 0
    name = b""
    for brace in re.finditer(rb"[{}]", text):
        place = brace.start()
        if brace.group() == b"{":
            if depth == 0:
                name, opening = text[start:place].strip(), place + 1
            depth += 1
        elif depth:
            depth -= 1
            if depth == 0:
                start = place + 1
                if name == key or name.endswith(b" " + key):
                    return text[opening:place]
    return None
