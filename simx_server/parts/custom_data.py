"""Named bytes that scripts keep with an object, the scene or the server.

They outlive the end of a run, as in V-REP; names that start with ``@tmp`` do not. The data of an object disappear with
the object, those of the scene with the scene; copies of an object start with the same data. A scene's file may bring
data along: `simx:data:NAME`, of the scene itself `simx:data:world`, and references `simx:references:NAME`. Saved scenes
and models have theirs there.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping
from typing import TYPE_CHECKING

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import UNTAGGED, Annotation
from simx_server.scene.formats.texts.values import decode_bytes, encode_bytes
from simx_server.scene.saved import listed
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

SCENE, APPLICATION = -12, -13
"""`sim_handle_scene` and `sim_handle_app`, used in place of an object's handle."""

HIDDEN = "\0"
"""Prefix of the server's private names, which scripts cannot access; removing everything keeps them."""

PART_EXTENSION = HIDDEN + "extension/"
"""Prefix of the names under which extension strings of a shape's parts are stored, by their index."""

EXTENSION = PART_EXTENSION + "-1"
"""Name under which an object's extension string is stored."""

REFERENCES = HIDDEN + "references/"
"""Prefix of the names under which an object's references to others are stored, per tag: handles of 32 bits."""

NUMBERED = HIDDEN + "numbered/"
"""Prefix of the names under which data with a number in place of a name are stored."""

NAMED = HIDDEN + "named/"
"""Prefix of the names under which named parameters of the server are stored."""

_TAG = re.compile(r"&\w{1,20}&\.")
"""Text before the name of data with a type in CoppeliaSim's files, such as ``&int&.count``; blocks have no tag."""

_TEMPORARY = "@tmp"

MOST_NAMES = 1000
"""Custom data of an object, the scene or the server: reading a name looks at all of them."""


class CustomData(Part):
    """All custom data of one simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._known: dict[int, dict[str, bytes]] = {}
        self._bytes: int | None = None
        """The size of all data; None when others than `write_typed` have changed them."""

        self._has_changed = False
        """Objects of data may have gone."""

    def scene_changed(self) -> None:
        self._forget_scene()

    def model_changed(self, twins: Twins | None) -> None:
        self._has_changed = True

    def run_stopped(self) -> None:
        self._forget_temporary()

    def write(self, handle: int, name: str, data: bytes) -> None:
        """Store data under a name; without data, remove this name; without a name, remove everything.

        Raises UnknownHandle, LimitReached.
        """
        if name and data:
            self.write_typed(handle, name, "", data)
            return
        known, self._bytes = self._of(handle), None
        if name:
            known.pop(name, None)
        else:
            for each in [kept for kept in known if not kept.startswith(HIDDEN)]:
                del known[each]

    def write_typed(self, handle: int, name: str, tag: str, data: bytes) -> None:
        """Store data with a type under a name, which replaces other data of this name; empty data are kept.

        Args:
            handle: of an object, or SCENE or APPLICATION.
            name: the name.
            tag: of the type, such as ``&int&.``; '' for a block of bytes.
            data: the packed value.

        Raises:
            UnknownHandle: the object does not exist.
            LimitReached: there would be too many data.
        """
        known, key = self._of(handle), tag + name
        if key not in known and len(known) >= MOST_NAMES:
            raise CommandError(f"at most {MOST_NAMES} custom data of an object or the scene: remove some")
        present = self._bytes
        if present is None:
            present = sum(map(_total, self._known.values()))
        wanted = present - (_size(key, known[key]) if key in known else 0) + _size(key, data)
        self._sim.limits.check("custom_data", wanted, "remove some")
        own = _split(key)[1]
        for each in [other for other in known if other.endswith(own) and other != key]:
            if _split(each)[1] == own:
                wanted -= _size(each, known.pop(each))
        known[key], self._bytes = data, wanted

    def read_typed(self, handle: int, name: str) -> tuple[str, bytes] | None:
        """Return the tag of the type and the data of a name, or None. Raises UnknownHandle."""
        for key, data in self._of(handle).items():
            if key.endswith(name):
                tag, own = _split(key)
                if own == name:
                    return tag, data
        return None

    def erase(self, handle: int, name: str) -> bool:
        """Remove the data of a name, of any type; return whether there were any. Raises UnknownHandle."""
        known = self._of(handle)
        gone = [key for key in known if _split(key)[1] == name]
        for key in gone:
            del known[key]
            self._bytes = None
        return bool(gone)

    def typed_names(self, handle: int) -> list[str]:
        """Return the names of all data of scripts, of any type, without tags. Raises UnknownHandle."""
        return [_split(key)[1] for key in self._of(handle) if not key.startswith(HIDDEN)]

    def read(self, handle: int, name: str) -> bytes | None:
        """Return the data of this name, or None. Raises UnknownHandle."""
        return self._of(handle).get(name)

    def names(self, handle: int) -> list[str]:
        """Return the names in the order in which they were first written. Raises UnknownHandle."""
        return list(self._of(handle))

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        """Copy the data of originals to their copies; references to copied objects then mean the copies."""
        self._bytes = None
        for original, copy in copies.items():
            if original not in self._known:
                continue
            self._known[copy] = {
                name: _renumbered(content, copies) if name.startswith(REFERENCES) else content
                for name, content in self._known[original].items()
                if (kept.references if name.startswith(REFERENCES) else kept.data or name.startswith(HIDDEN))
            }

    def saving(self, saved: Saved) -> None:
        for handle in saved.names:
            data = self._of(handle)
            saved.drop(handle, "data")
            saved.drop(handle, "references")
            saved.put(handle, "data", **_blocks(data))
            for name, packed in data.items():
                if name.startswith(REFERENCES) and packed:
                    names = listed(saved.name(each) or "" for each in _handles(packed))
                    saved.put(handle, "references", **{name.removeprefix(REFERENCES) or UNTAGGED: names})
            text = data.get(EXTENSION, b"").decode("utf-8", "surrogateescape")
            saved.put(handle, "object", extension=text or None)
        if not saved.is_model:
            saved.data = _blocks(self._of(SCENE))
            places = {handle: place for place, handle in enumerate(saved.names, 1)}
            for name, packed in self._of(SCENE).items():
                if name.startswith(REFERENCES):
                    handles = [places.get(each, -1) for each in _handles(packed)]
                    saved.data[name] = encode_bytes(struct.pack(f"<{len(handles)}i", *handles))

    def _of(self, handle: int) -> dict[str, bytes]:
        if handle not in (SCENE, APPLICATION):
            self._sim.scene.get(handle)
        if self._has_changed and not self._sim.is_running:  # a stop may restore objects that a run removed
            self._has_changed, self._bytes = False, None
            for each in [each for each in self._known if each >= 0 and each not in self._sim.scene.objects]:
                del self._known[each]
        if handle not in self._known:
            found = self._known[handle] = self._in_file(handle)
            if self._bytes is not None:
                self._bytes += _total(found)
        return self._known[handle]

    def _in_file(self, handle: int) -> dict[str, bytes]:
        """Return the data that the scene's file gives to an object, or to the scene itself."""
        item = self._sim.scene.objects.get(handle)
        notes = {"data": self._sim.scene.annotations.data} if handle == SCENE else {}
        if item is not None:
            notes = item.annotations
        found = {name: decode_bytes(str(text)) for name, text in notes.get("data", {}).items()}
        for name in [
            name for name in found if name.startswith(REFERENCES)
        ]:  # of the scene: objects have names
            found[name] = found[name][: len(found[name]) // 4 * 4]
        for tag, words in notes.get("references", {}).items():
            named = [self._sim.scene.by_name(word) if word else None for word in str(words).split(",")]
            handles = [-1 if each is None else each for each in named]
            found[f"{REFERENCES}{'' if tag == UNTAGGED else tag}"] = struct.pack(
                f"<{len(handles)}i", *handles
            )
        if "extension" in notes.get("object", {}):
            found[EXTENSION] = str(notes["object"]["extension"]).encode("utf-8", "surrogateescape")
        return found

    def _forget_scene(self) -> None:
        self._bytes = None
        self._known = {APPLICATION: self._known.get(APPLICATION, {})}

    def _forget_temporary(self) -> None:
        self._bytes = None
        for kept in self._known.values():
            for name in [each for each in kept if _split(each)[1].startswith(_TEMPORARY)]:
                del kept[name]


def _blocks(data: Mapping[str, bytes]) -> Annotation:
    """Return the data that are saved as they are: not temporary ones, nor those with handles."""
    return {
        name: encode_bytes(content)
        for name, content in data.items()
        if not name.startswith(REFERENCES)
        and name != EXTENSION
        and not _split(name)[1].startswith(_TEMPORARY)
    }


def _handles(packed: bytes) -> tuple[int, ...]:
    return struct.unpack(f"<{len(packed) // 4}i", packed)


def _renumbered(packed: bytes, copies: Mapping[int, int]) -> bytes:
    """Return packed handles with those of copies in place of originals."""
    handles = _handles(packed)
    return struct.pack(f"<{len(handles)}i", *(copies.get(each, each) for each in handles))


def _size(key: str, data: bytes) -> int:
    """Return the bytes that count against the limit; empty data count by their name."""
    return len(data) or len(key)


def _total(data: Mapping[str, bytes]) -> int:
    return sum(_size(key, content) for key, content in data.items())


def _split(key: str) -> tuple[str, str]:
    """Return the tag of the type, '' for a block, and the name without it."""
    found = _TAG.match(key)
    return (found[0], key[found.end() :]) if found else ("", key)
