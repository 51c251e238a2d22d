"""Objects that refuse a misspelt attribute, read or set, and name the nearest one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.nearest import nearest

_LISTED = 30
"""With more attributes than this, an error message does not list them all."""


def misspelt(thing: object, name: str, hint: str = "") -> AttributeError:
    """Make the error for an attribute that an object does not have.

    Args:
        hint: what to do instead; without one the nearest name is given, or all names.
    """
    if not (hint or name.startswith("_")):
        names = [each for each in dir(type(thing)) if not each.startswith("_")]
        if near := nearest(name, names, 1):
            hint = f"did you mean {near[0]!r}?"
        elif len(names) <= _LISTED:
            hint = f"it has: {', '.join(names)}"
    text = f"{type(thing).__name__!r} object has no attribute {name!r}"
    # Without an object Python adds no guess of its own to ours.
    return AttributeError(f"{text}; {hint}" if hint else text, name=name, obj=None)


class Explained:
    """Reading an attribute that is not there raises AttributeError with the nearest name.

    Subclasses have ``__slots__``, so setting one raises too. A class that a user derives has none and takes any.
    """

    __slots__ = ()

    def _hint(self, name: str) -> str:
        """What to do instead of taking an attribute of this name, if a class knows better than the nearest name."""
        return ""

    if not TYPE_CHECKING:  # a type checker would take it for a permission

        def __getattr__(self, name: str) -> object:
            if hasattr(type(self), name):  # a property that raised AttributeError has its own words
                return object.__getattribute__(self, name)
            raise misspelt(self, name, self._hint(name))


class Strict(Explained):
    """As ``Explained``, also in the words for an attribute that is set."""

    __slots__ = ()

    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: object) -> None:
            try:
                object.__setattr__(self, name, value)
            except AttributeError:
                if hasattr(type(self), name):  # a property that cannot be set, or whose setter raised
                    raise
                raise misspelt(self, name, self._hint(name)) from None
