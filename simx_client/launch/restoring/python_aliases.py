"""Restore names that old scripts use and newer Python versions removed from their modules.

Sources: "What's New in Python" 3.8 (``time.clock``), 3.9 (``fractions.gcd``, ``Thread.isAlive``, ``array.tostring``,
``base64.encodestring``), 3.10 (the abstract classes in ``collections``), 3.11 (``inspect.getargspec``). Wrappers around
the legacy binding read the parameter names of its functions with the last one.
"""

from __future__ import annotations

import array
import base64
import inspect
import math
import threading
import time
from collections import abc
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

from simx_client.launch.after_import import Patch

from .immutable import set_attributes
from .keywords import give_missing


class ArgSpec(NamedTuple):
    """Result of ``inspect.getargspec``."""

    args: list[str]
    varargs: str | None
    keywords: str | None
    defaults: tuple[Any, ...] | None


def getargspec(func: Callable[..., Any]) -> ArgSpec:
    """Return names and defaults of a function's parameters."""
    return ArgSpec(*inspect.getfullargspec(func)[:4])


def _giving(**members: Any) -> Patch:
    return lambda module: give_missing(module, **members)


def _threads(_: ModuleType) -> None:
    give_missing(threading.Thread, isAlive=threading.Thread.is_alive)


def _arrays(_: ModuleType) -> None:
    if not hasattr(array.array, "tostring"):
        kind: Any = array.array
        set_attributes(kind, {"tostring": kind.tobytes, "fromstring": kind.frombytes})


ALIASES: dict[str, Patch] = {
    "time": _giving(clock=time.perf_counter),
    "inspect": _giving(getargspec=getargspec, ArgSpec=ArgSpec),
    "collections": _giving(**{name: getattr(abc, name) for name in dir(abc) if name[0].isupper()}),
    "fractions": _giving(gcd=math.gcd),
    "threading": _threads,
    "array": _arrays,
    "base64": _giving(encodestring=base64.encodebytes, decodestring=base64.decodebytes),
}
"""Patch by the name of the module."""
