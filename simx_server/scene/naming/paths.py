"""Resolve a text to a handle: old V-REP names (`name`, `name#`, `name#0`) and paths (`/alias[1]/alias`, `./`, `*`)."""

from __future__ import annotations

import fnmatch
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from typing import Protocol

from simx_server.errors import UnknownName

from .alike import names_like
from .names import alias_of

_INDEX = re.compile(r"^(?P<alias>.*)(?:\[(?P<index>\d+)\]|\{(?P<among_all>\d+)\})$")

_LONGEST = 10_000
"""Characters of a name or path: no object has a longer one."""

_LINK_SHAPES = ("_respondable", "_visual")
"""Suffixes that V-REP's importer of URDF appends to the names of links."""


class Named(Protocol):
    """An object of a scene, as its name and its place in the tree are concerned; see `objects.SceneObject`."""

    name: str
    alias: str
    parent: int
    element: str


class Tree(Protocol):
    """A tree of named objects; `objects.Scene` documents the members."""

    @property
    def objects(self) -> Mapping[int, Named]: ...
    def by_name(self, name: str) -> int | None: ...
    def by_names(self) -> Mapping[str, int]: ...
    def children(self, handle: int) -> list[int]: ...
    def descendants(self, handle: int) -> list[int]: ...
    def is_model_base(self, handle: int) -> bool: ...


def resolve(scene: Tree, text: str, origin: int = -1) -> int:
    """Return the handle meant by `text`.

    Old name: exactly `name`; one trailing `#` is dropped; `name@alt` and `name@silentError` mean `name`.
    `NAME_visual` and `NAME_respondable` mean the body `NAME` if they do not exist: a link of a URDF is one body here.
    Path (starts with `/`, `.` or `:`): each component is an alias, or an old name, somewhere below the one before it.
    `[i]` picks the i-th (from 0) of the children of one object, or of all if none has that many, `{i}` the i-th of all;
    `*` and `?` are wildcards; `./` starts at `origin`, `../` at its parent, `:/` at its model, `::/` at the model above
    that, `/` at the top.
    Raises UnknownName, whose text lists the nearest names, or paths if a path was given.
    """
    if len(text) > _LONGEST:
        raise UnknownName(text, list)
    plain, _, suffix = text.partition("@")
    silent = suffix.lower() == "silenterror"
    is_path = plain.startswith(("/", ".", ":"))
    if is_path:
        found = _resolve_path(scene, plain, origin)
    else:
        name = plain.removesuffix("#")
        found = scene.by_name(name)
        if found is None:
            found = _link_of(scene, name)
    if found is None:
        raise UnknownName(text, _advice(scene, plain, is_path=is_path), silent=silent)
    return found


def _link_of(scene: Tree, name: str) -> int | None:
    """Return the link that V-REP's importer of URDF splits into two shapes, one visible and one that collides."""
    alias = alias_of(name)
    for suffix in _LINK_SHAPES:
        if alias.endswith(suffix):
            found = scene.by_name(alias.removesuffix(suffix) + name.removeprefix(alias))
            if found is not None and scene.objects[found].element == "body":
                return found
    return None


def _advice(scene: Tree, text: str, *, is_path: bool) -> Callable[[], list[str]]:
    """Return a function that returns names, or paths, of the present scene that resemble a wrong one, best first."""
    names = scene.by_names()  # a later scene has other ones
    wanted = text.strip("/.:").rsplit("/", 1)[-1]
    if not is_path:
        return lambda: names_like(wanted, names)
    paths = paths_of(scene, [names[name] for name in names_like(wanted, names)])
    return lambda: paths


def path_of(scene: Tree, handle: int) -> str:
    """Return the full path of an object; an index is added where siblings share the alias."""
    return paths_of(scene, [handle])[0]


def paths_of(scene: Tree, handles: Iterable[int]) -> list[str]:
    """Return the full paths of objects, as `path_of`; the children of an object are counted once for all of them."""
    parts: dict[int, dict[int, str]] = {}
    paths = {-1: ""}
    found: list[str] = []
    for handle in handles:
        way: list[int] = []
        while handle not in paths:
            way.append(handle)
            handle = scene.objects[handle].parent
        path = paths[handle]
        for each in reversed(way):
            above = scene.objects[each].parent
            if above not in parts:
                parts[above] = path_parts(scene, above)
            path = paths[each] = f"{path}/{parts[above][each]}"
        found.append(path or "/")
    return found


def indexed_path(scene: Tree, handle: int, models: int | None) -> str:
    """Return a path with an index in each part, ``/model{0}/alias{3}``: among all objects of this alias below the
    part before it.

    Args:
        models: how many of the model bases above the object are parts, the nearest ones; None: all.
    """
    chain = [handle]
    above = scene.objects[handle].parent
    while above != -1 and (models is None or len(chain) <= models):
        if scene.is_model_base(above):
            chain.append(above)
        above = scene.objects[above].parent
    parts: list[str] = []
    base = -1
    for each in reversed(chain):
        alias = scene.objects[each].alias
        twins = [other for other in scene.descendants(base) if scene.objects[other].alias == alias]
        parts.append(f"{alias}{{{twins.index(each)}}}")
        base = each
    return "/" + "/".join(parts)


def path_parts(scene: Tree, parent: int) -> dict[int, str]:
    """Return the part of the path of each child of an object, by handle, in hierarchy order; -1 for the top level."""
    aliases = {child: scene.objects[child].alias for child in scene.children(parent)}
    twins = Counter(aliases.values())
    places: Counter[str] = Counter()
    parts: dict[int, str] = {}
    for child, alias in aliases.items():
        parts[child] = alias if twins[alias] == 1 else f"{alias}[{places[alias]}]"
        places[alias] += 1
    return parts


def _resolve_path(scene: Tree, text: str, origin: int) -> int | None:
    places = [-1 if text.startswith("/") else origin]
    found_any = False
    for part in text.split("/"):
        if part in ("", "."):
            continue
        if part in _UPWARDS:
            places = [_UPWARDS[part](scene, places[0])]
            found_any = places[0] != -1
            continue
        match = _INDEX.match(part)
        alias, index = (match["alias"], int(match["index"] or match["among_all"])) if match else (part, None)
        if (
            match
            and match["index"]
            and (found := _among_siblings(scene, places, alias, int(index or 0))) != -1
        ):
            places, found_any = [found], True
            continue
        below = [h for place in places for h in _below(scene, place) if _fits(scene, h, alias)]
        places = below if index is None else below[index : index + 1]
        found_any = bool(places)
        if not found_any:
            return None
    if not found_any:
        return origin if origin in scene.objects and text in (".", "./") else None
    return places[0]


def _parent(scene: Tree, handle: int) -> int:
    return -1 if handle == -1 else scene.objects[handle].parent


def _model(scene: Tree, handle: int) -> int:
    """Return the nearest model base from an object upwards, itself included; -1 for none."""
    while handle != -1 and not scene.is_model_base(handle):
        handle = _parent(scene, handle)
    return handle


def _model_above(scene: Tree, handle: int) -> int:
    return _model(scene, _parent(scene, _model(scene, handle)))


_UPWARDS = {"..": _parent, ":": _model, "::": _model_above}
"""Parts of a path that lead from an object to one above it, or for ``:`` to itself."""


def _below(scene: Tree, base: int) -> Iterator[int]:
    """Yield the objects below one in CoppeliaSim's order: all children first, then in the same way below each child."""
    waiting = [base]
    while waiting:
        children = scene.children(waiting.pop())
        yield from children
        waiting.extend(reversed(children))


def _among_siblings(scene: Tree, places: Collection[int], alias: str, index: int) -> int:
    """Return the object that ``alias[index]`` means in CoppeliaSim: counted among the children of one object.

    The search goes on below, where the count starts again. -1: no object has that many children of this alias.
    """
    for place in places:
        for parent in (place, *_below(scene, place)):
            found = [child for child in scene.children(parent) if _fits(scene, child, alias)]
            if index < len(found):
                return found[index]
    return -1


def _fits(scene: Tree, handle: int, pattern: str) -> bool:
    item = scene.objects[handle]
    return item.name == pattern.removesuffix("#") or fnmatch.fnmatchcase(item.alias, pattern)
