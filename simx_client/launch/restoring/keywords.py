"""Make functions accept keyword arguments that a library renamed or removed."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

DROPPED = None
"""Instead of a new name: the argument has no meaning any more."""


def take_old_keywords(owner: Any, function: str, **old: str | None) -> None:
    """Replace a function of a module or class by one that also takes old keywords.

    Args:
        owner: the module or class; without the function nothing is done.
        old: old keyword to new one, or DROPPED. A keyword that the function still has stays unchanged.
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
                kwargs[new] = value  # also replaces a default that pyplot passes on
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
