"""One fact about objects: how it is read in a world, and how it is written into the records of a V-REP file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from simx_server.scene.formats.vrep.conversion.geometry.surfaces import Surfaces
    from simx_server.scene.formats.vrep.writing.meshes import MeshPools
    from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
    from simx_server.scene.formats.vrep.writing.record_lists import RecordList
    from simx_server.world.world import World


class NotInVrepFiles(CommandError):
    """Something in the world that is not written into V-REP's files; the text names it."""


@dataclass(frozen=True, slots=True)
class Handle:
    """The handle of an object, or of a collection, within the value of a fact; worlds and files number them apart."""

    number: int


@dataclass(slots=True)
class Writing:
    """Facts that the records of all objects of a file share."""

    serialization: int
    """Version of the file's format."""
    numbers: Mapping[int, int]
    """Handles of the saved objects in the world, and in the file."""
    collections: Mapping[int, int] = field(default_factory=dict[int, int])
    """The same of collections."""
    scripts: Mapping[int, Sequence[RecordList]] = field(default_factory=dict[int, Sequence["RecordList"]])
    """The scripts of the saved objects, by the handles of these."""
    pools: MeshPools | None = None
    """The meshes of the file; None in versions that have them in the shapes."""

    textures: list[tuple[int, NDArray[np.uint8]]] = field(
        default_factory=list[tuple[int, "NDArray[np.uint8]"]]
    )
    """New textures with their numbers: (rows, columns, 4) red, green, blue, opacity."""
    surfaces: Surfaces | None = None
    """The engine of the file, and the friction of its ground."""
    new_pairs: list[str] = field(default_factory=list[str])
    """Names of new collision and distance objects."""
    new_uis: list[str] = field(default_factory=list[str])
    """Names of new old UIs."""
    brought_textures: list[bytes] = field(default_factory=list[bytes])
    """Payloads of textures of other files, with their new numbers."""
    free_texture: int = 1
    """Number of the next texture."""

    def add_texture(self, pixels: NDArray[np.uint8]) -> int:
        """Add a texture, unless it is there; return its number."""
        for number, known in self.textures:
            if known.shape == pixels.shape and bool((known == pixels).all()):
                return number
        self.textures.append((self.take_texture_number(), pixels))
        return self.textures[-1][0]

    def take_texture_number(self) -> int:
        """Return a number that no texture of the file has."""
        self.free_texture += 1
        return self.free_texture - 1

    @property
    def all_numbers(self) -> Mapping[int, int]:
        """Return the numbers of objects and collections by handle."""
        return {**self.numbers, **self.collections}

    def number(self, handle: Handle) -> int:
        """Return the number of an object or collection in the file, -1 for one that the file has not."""
        return self.numbers.get(handle.number, self.collections.get(handle.number, -1))


@dataclass(frozen=True, slots=True)
class Field:
    """A fact that objects of some kind have."""

    get: Callable[[World, int], Any]
    """Returns the value: numbers, texts, bytes, `Handle`, and tuples and mappings of them. None: there is nothing."""
    put: Callable[[ObjectRecords, Any, Writing], None]
    """Writes it. Raises NotInVrepFiles."""
    of_new: bool = True
    """Whether it is written for objects that come from no file; else they have what programs give to new ones."""
    is_usual: Callable[[Any], bool] | None = None
    """Whether a value of a new object is the usual one, which need not be written."""
    concerns: Callable[[Mapping[str, Any], Mapping[str, Any]], bool] | None = None
    """Whether a difference counts, by the present facts of the object and those of the file; None: it does."""


Fields = Mapping[str, Field]
"""By a name for messages."""


def unwritable(what: str) -> Callable[[ObjectRecords, Any, Writing], None]:
    """Return the writer of a fact that V-REP's files cannot have, or that is not written."""

    def put(_records: ObjectRecords, _value: Any, _writing: Writing) -> None:
        raise NotInVrepFiles(what)

    return put
