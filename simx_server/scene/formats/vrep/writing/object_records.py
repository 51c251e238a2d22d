"""The records of one object: those that all objects have, and those of its kind."""

from __future__ import annotations

from .record_lists import END, RecordList, split

_NEXT = b"NXT"


class ObjectRecords:
    """The records of an object, which can be changed."""

    def __init__(self, tag: str, common: RecordList, own: RecordList) -> None:
        """Make them of two lists.

        Args:
            tag: the kind of object, as in the file: SHP, JNT and so on.
            common: records that all objects have.
            own: records of this kind.
        """
        self.tag, self.common, self.own = tag, common, own

    @classmethod
    def parse(cls, tag: str, payload: bytes, serialization: int) -> ObjectRecords:
        """Return the records in an object's payload. Raises SceneError."""
        common, own = split(["object", tag], payload, serialization)
        return cls(tag, common, own)

    @classmethod
    def new(cls, tag: str, serialization: int) -> ObjectRecords:
        """Return an object without any record."""
        return cls(tag, RecordList("object", serialization), RecordList(tag, serialization))

    def __bytes__(self) -> bytes:
        return bytes(self.common) + _NEXT + bytes(self.own) + END

    @property
    def handles(self) -> tuple[int, int]:
        """Return its own handle and that of its parent."""
        own, parent = self.common.numbers("Ids") or (-1, -1)
        return int(own), int(parent)
