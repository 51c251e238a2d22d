"""XML from outside: entities, which can expand a short text beyond all memory or read other files, are refused."""

from __future__ import annotations

from xml.parsers import expat

from .annotations import SceneError


class _Declared(Exception):
    """A text declares an entity."""


class _Begun(Exception):
    """The start of the first element, behind which nothing is declared."""


def refuse_entities(data: bytes, name: str) -> bool:
    """Refuse a text that declares entities.

    Returns:
        Whether it is well-formed XML up to its first element. Readers other than Python's own know more encodings, so
        they must not get another text.

    Raises:
        SceneError: it declares one.
    """

    def refuse(*_: object) -> int:
        raise _Declared

    def begin(*_: object) -> None:
        raise _Begun

    parser = expat.ParserCreate()
    parser.EntityDeclHandler = refuse
    parser.ExternalEntityRefHandler = refuse
    parser.StartElementHandler = begin
    try:
        parser.Parse(data, True)
    except _Begun:
        return True
    except _Declared:
        raise SceneError(
            f"'{name}' declares XML entities, which are not expanded; write their text out"
        ) from None
    except (expat.ExpatError, ValueError, LookupError):
        pass
    return False
