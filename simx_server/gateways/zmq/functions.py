"""The meaning of a function's name, found once for all calls with it."""

from __future__ import annotations

import typing
from functools import lru_cache
from typing import Any, NamedTuple

from simx_server import sim_api as api
from simx_server.scripting.conversion.strings import GIVES_BYTES, GIVES_TEXT
from simx_server.sim_api.effects import Effect
from simx_server.sim_api.namespaces import effects, signatures

from .wire.messages import EVAL

MOST_REMEMBERED = 4096
"""Names; there are some 1,500 functions, and clients may invent names."""


_OWN = "zmqRemoteApi"
"""The namespace of CoppeliaSim's add-on."""

_READABLE = ("sim", _OWN)
"""Namespaces with functions for viewers."""


class Function(NamedTuple):
    """A name that a client calls."""

    space: str
    """Its namespace; ``sim`` for ``sim-2.step``."""

    name: str
    full_name: str
    """Both, as the namespaces know it."""

    is_known: bool
    """A namespace has it."""

    is_typed: bool
    """It declares the types of all its results, and its bytes are never text."""

    gives_bytes: bool
    """Its texts are bytes, as far as it declares no types."""

    effect: Effect | None
    """Its effect; None: no function has this name."""

    only_reads: bool
    """A viewer may call it: one of ``sim`` or of this protocol, which others do not notice."""


@lru_cache(MOST_REMEMBERED)
def described(full_name: str) -> Function:
    """Return the meaning of a name."""
    space, name = split_name(full_name)
    is_known = space in api.NAMESPACES and name in signatures(space)
    effect = effects(space)[name] if is_known else _effect_of_own(space, full_name)
    return Function(
        space,
        name,
        f"{space}.{name}",
        is_known,
        is_known and not GIVES_TEXT.search(full_name) and _is_typed(getattr(api.NAMESPACES[space], name)),
        bool(GIVES_BYTES.search(full_name)),
        effect,
        effect == "reads" and space in _READABLE,
    )


def _effect_of_own(space: str, full_name: str) -> Effect | None:
    """Return what a function of this protocol does, which no script has."""
    if space != _OWN:
        return None
    return "runs code" if full_name == EVAL else "reads"


def split_name(full_name: str) -> tuple[str, str]:
    """Return the namespace and the name of a function; ``sim-2.step`` means that of ``sim``."""
    space, _, name = full_name.partition(".")
    return space.partition("-")[0], name


def _is_typed(function: Any) -> bool:
    return not _is_open(typing.get_type_hints(function).get("return"))


def _is_open(annotation: Any) -> bool:
    """Return whether a type contains Any, a map or a result that comes later."""
    if annotation is Any or (typing.get_origin(annotation) or annotation) in (dict, typing.NoReturn):
        return True
    return any(_is_open(each) for each in typing.get_args(annotation))
