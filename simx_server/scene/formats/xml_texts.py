"""XML from outside: entities, which can expand a short text beyond all memory or read other files, are refused."""

from __future__ import annotations

from xml.etree import ElementTree
from xml.parsers import expat

from .annotations import SceneError


class _Declared(Exception):
    """A text declares an entity."""


def refuse_entities(data: bytes, name: str) -> None:
    """Refuse a text that declares entities. A text that is not well-formed passes: its reader reports that.

    Raises:
        SceneError: it declares one.
    """

    def refuse(*_: object) -> int:
        raise _Declared

    if b"<!" not in data and b"<\0!" not in data and b"\0<\0!" not in data:
        return
    parser = expat.ParserCreate()
    parser.EntityDeclHandler = refuse
    parser.ExternalEntityRefHandler = refuse
    try:
        parser.Parse(data, True)
    except _Declared:
        raise SceneError(
            f"'{name}' declares XML entities, which are not expanded; write their text out"
        ) from None
    except (expat.ExpatError, ValueError, LookupError):
        return


def parse_xml(data: bytes, name: str) -> ElementTree.Element:
    """Return the root of a text.

    Raises:
        SceneError: it declares entities.
        xml.etree.ElementTree.ParseError, ValueError, LookupError: it is not well-formed.
    """
    refuse_entities(data, name)
    return ElementTree.fromstring(data)
