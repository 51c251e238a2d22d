"""Keyword arguments that a library renamed or dropped are taken again, by functions that no longer know them."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

DROPPED = None
"""In place of a new name: the argument no longer means anything."""


def take_old_keywords(owner: Any, function: str, **old: str | None) -> None:
    """Replace a function of a module or class by one that takes old keywords, too.

    Args:
        owner: where the function is; without it nothing is done.
        old: old keyword to new one, or DROPPED. One that the function still names is left alone.
    """
    plain: Callable[..., Any] | None = getattr(owner, function, None)
    if plain is None or hasattr(plain, "takes_old_keywords"):
        return
    known = inspect.signature(plain).parameters
    renamed = {name: new for name, new in old.items() if name not in known}

    @functools.wraps(plain)
    def with_old_keywords(*args: Any, **kwargs: Any) -> Any:
        for name in renamed.keys() & kwargs.keys():
            value, new = kwargs.pop(name), renamed[name]
            if new is not None:
                kwargs[new] = value  # also over a default that pyplot passes on
        return plain(*args, **kwargs)

    setattr(with_old_keywords, "takes_old_keywords", True)  # noqa: B010 - its type does not know the attribute
    setattr(owner, function, with_old_keywords)


def calling(method: str) -> Callable[..., Any]:
    """Return a method that passes its arguments to another one of the same object."""

    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        return getattr(self, method)(*args, **kwargs)

    return call


def give_missing(owner: Any, **members: Any) -> None:
    """Set the members that a module or class does not have."""
    for name, value in members.items():
        if not hasattr(owner, name):
            setattr(owner, name, value)
