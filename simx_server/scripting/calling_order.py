"""The order in which scripts are called: by the tree of their objects, as V-REP does.

A script is called after all scripts below its object, or with forward traversal before them. Among siblings those that
are marked as first come first, with everything below them, and those marked as last come last.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, NamedTuple

from .script import Order, Script, ScriptKind, Traversal

if TYPE_CHECKING:
    from simx_server.scene.objects import Scene

_BEFORE, _AFTER = (int(Order.FIRST) - 1,), (int(Order.LAST) + 1,)
"""Ends of a place: before and after everything below the object."""

_Place = tuple[tuple[int, ...], ...]
_Homes = Mapping[tuple[int, ScriptKind], Script]


class Called(NamedTuple):
    """The scripts of a scene in the order in which they are called."""

    every: tuple[Script, ...] = ()
    main: tuple[Script, ...] = ()
    children: tuple[Script, ...] = ()
    customizations: tuple[Script, ...] = ()


def called(scripts: Iterable[Script], scene: Scene) -> Called:
    """Return the scripts of a scene, and those of each kind."""
    scripts = list(scripts)
    kinds = (ScriptKind.MAIN, ScriptKind.CHILD, ScriptKind.CUSTOMIZATION)
    of_kinds = ([one for one in scripts if one.kind == kind] for kind in kinds)
    return Called(*(tuple(in_calling_order(some, scene)) for some in (scripts, *of_kinds)))


def in_calling_order(scripts: Iterable[Script], scene: Scene) -> list[Script]:
    """Return the scripts in the order in which they are called; of several kinds on one object, in the given order."""
    scripts = list(scripts)
    places = scene.leaves_first()
    if all(one.order == Order.NORMAL and one.traversal != Traversal.FORWARD for one in scripts):
        return sorted(scripts, key=lambda one: places.get(one.home, -1))
    homes = {(one.home, one.kind): one for one in scripts}
    return sorted(scripts, key=lambda one: _place(one, homes, scene))


def _place(script: Script, homes: _Homes, scene: Scene) -> _Place:
    """Return where a script comes: order and place of each object from the top of the tree down to its own."""
    places, objects = scene.leaves_first(), scene.objects
    path: list[tuple[int, ...]] = []
    traversal, handle = Traversal.PARENT, script.home
    while handle in objects:
        here = homes.get((handle, script.kind))
        if here is not None and traversal == Traversal.PARENT:
            traversal = here.traversal
        path.append((int(here.order if here is not None else Order.NORMAL), places[handle]))
        handle = objects[handle].parent
    return (*reversed(path), _BEFORE if traversal == Traversal.FORWARD else _AFTER)
