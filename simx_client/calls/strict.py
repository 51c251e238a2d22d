"""Objects that refuse a misspelt attribute and name the nearest one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_client.protocol.nearest import nearest

_LISTED = 30
"""Maximum number of attributes that an error message lists."""


def misspelt(thing: object, name: str, hint: str = "") -> AttributeError:
    """Make the error for an attribute that an object does not have.

    Args:
        hint: what to do instead; without it the text contains the nearest name, or all names.
    """
    if not (hint or name.startswith("_")):
        names = [each for each in dir(type(thing)) if not each.startswith("_")]
        if near := nearest(name, names, 1):
            hint = f"did you mean {near[0]!r}?"
        elif len(names) <= _LISTED:
            hint = f"it has: {', '.join(names)}"
    text = f"{type(thing).__name__!r} object has no attribute {name!r}"
    # without an object Python adds no suggestion to the text
    return AttributeError(f"{text}; {hint}" if hint else text, name=name, obj=None)


class Explained:
    """Reading an unknown attribute raises AttributeError with the nearest name.

    Subclasses have ``__slots__``, so setting one raises too. A class that a user derives has none and takes
    any.
    """

    __slots__ = ()

    def _hint(self, name: str) -> str:
        """Return what to do instead of reading this attribute, if a class has a better hint than the nearest
        name."""
        return ""

    if not TYPE_CHECKING:  # a type checker would accept any attribute

        def __getattr__(self, name: str) -> object:
            if hasattr(type(self), name):  # a property that raised AttributeError has a better text
                return object.__getattribute__(self, name)
            raise misspelt(self, name, self._hint(name))


class Strict(Explained):
    """As ``Explained``, also for an attribute that is set."""

    __slots__ = ()

    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: object) -> None:
            try:
                object.__setattr__(self, name, value)
            except AttributeError:
                if hasattr(type(self), name):  # a property that cannot be set, or whose setter raised
                    raise
                raise misspelt(self, name, self._hint(name)) from None
