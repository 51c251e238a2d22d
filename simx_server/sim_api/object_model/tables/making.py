"""Make properties of API 2: of those of API 1, of settings that are only kept, and of those that are refused."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from simx_server.errors import CommandError, Unsupported
from simx_server.parts.custom_data import HIDDEN
from simx_server.sim_api.object_model.enumerations import number_of, word_of
from simx_server.sim_api.object_model.types import COLOR, MATRIX, enum_of
from simx_server.sim_api.object_model.values import Color, Matrix
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, renamed
from simx_server.sim_api.properties.property_types import PropertyType

if TYPE_CHECKING:
    from simx_server.world.world import World

_KEPT = HIDDEN + "kept/"
"""Start of the names of custom data that hold settings of windows."""


def by_name(properties: Iterable[Property]) -> dict[str, Property]:
    """Return properties by name; of several with one name the first."""
    found: dict[str, Property] = {}
    for each in properties:
        found.setdefault(each.name, each)
    return found


class Old:
    """The properties of API 1 of one kind of target."""

    def __init__(self, properties: Iterable[Property]) -> None:
        self._properties = by_name(properties)

    def __getitem__(self, name: str) -> Property:
        return self._properties[name]

    def same(self, names: str) -> list[Property]:
        """Return those of these names; a colour has API 2's type."""
        return [self.named(name, name) for name in names.split()]

    def named(self, old: str, new: str, kind: PropertyType | None = None) -> Property:
        """Return one under its new name, and perhaps with another type of the same family."""
        one = self._properties[old]
        return colored(one, new) if one.type is t.COLOR else renamed(one, new, kind)

    def enumerated(self, old: str, new: str, enumeration: str) -> Property:
        """Return an integer as an item of an enumeration."""
        return renamed(self._properties[old], new, enum_of(enumeration))

    def worded(self, old: str, new: str, enumeration: str) -> Property:
        """Return an integer as the name of an item of an enumeration."""
        return worded(self._properties[old], new, enumeration)

    def inverted(self, old: str, new: str) -> Property:
        """Return a switch that is on where the old one is off."""
        one = self._properties[old]
        get, put = one.get, one.set
        assert get is not None
        return Property(
            new,
            t.BOOL,
            lambda world, handle: not get(world, handle),
            put and (lambda world, handle, value: put(world, handle, not value)),
        )

    def matrix(self, old: str, new: str, rows: int, *, by_rows: bool = False) -> Property:
        """Return a list of numbers as a matrix; its columns are the items, or its rows."""
        one = self._properties[old]
        get, put = one.get, one.set
        assert get is not None

        def read(world: World, handle: int) -> Matrix:
            numbers = get(world, handle)
            return Matrix(rows, len(numbers) // rows, numbers) if by_rows else Matrix.of_points(numbers, rows)

        def write(world: World, handle: int, value: Matrix) -> None:
            assert put is not None
            put(world, handle, value.numbers if by_rows else value.points(rows))

        return Property(new, MATRIX, read, write if put else None, one.is_large, one.waits)


def worded(one: Property, name: str, enumeration: str) -> Property:
    """Return an integer as the name of an item of an enumeration."""
    get, put = one.get, one.set
    assert get is not None
    return Property(
        name,
        t.STRING,
        lambda world, handle: word_of(enumeration, get(world, handle)),
        put and (lambda world, handle, word: put(world, handle, number_of(enumeration, word))),
    )


def colored(one: Property, name: str) -> Property:
    """Return a colour of three parts as one of four bytes."""
    get, put = one.get, one.set
    return Property(
        name,
        COLOR,
        get and (lambda world, handle: Color.of(get(world, handle))),
        put and (lambda world, handle, value: put(world, handle, value.parts)),
    )


def kept(name: str, kind: PropertyType, first: Any) -> Property:
    """Return a setting of CoppeliaSim's windows, mouse or files, which the server keeps for programs and never uses."""

    def get(world: World, handle: int) -> Any:
        found = world.custom_data.read(handle, _KEPT + name)
        return first if found is None else kind.decode(found)

    def put(world: World, handle: int, value: Any) -> None:
        world.custom_data.write_typed(handle, _KEPT + name, "", kind.encode(value))

    return Property(name, kind, get, put)


def kept_colors(start: str, parts: Mapping[str, Color] | None = None) -> list[Property]:
    """Return the colours with which a window would draw a thing."""
    given = parts or {}
    first = {"diffuse": _GREY, "emission": _BLACK, "specular": _DARK, **given}
    return [kept(f"{start}.{part}", COLOR, color) for part, color in first.items()]


def refused(name: str, kind: PropertyType, why: str) -> Property:
    """Return a property that this server does not have: reading and setting it is an error with the reason."""

    def get(_world: World, _handle: int) -> Any:
        raise Unsupported(f"property '{name}' is not available here: {why}")

    def put(_world: World, _handle: int, _value: Any) -> None:
        get(_world, _handle)

    return Refused(name, kind, get, put)


class Refused(Property):
    """A property with a reason in place of a value."""


def engine_properties(properties: Iterable[Property]) -> Property:
    """Return the options of the physics engine as one text, JSON: ``{"mujoco": {"friction": [1, 0.005, 0.0001]}}``.

    Args:
        properties: the options as properties, with their names within a class.
    """
    known = {each.name.rpartition(".")[2]: each for each in properties}

    def get(world: World, handle: int) -> str:
        found = {name: each.get(world, handle) for name, each in known.items() if each.get is not None}
        return json.dumps({_ENGINE: found})

    def put(world: World, handle: int, text: str) -> None:
        for name, value in _options(text).items():
            one = known.get(name)
            if one is None or one.set is None:
                raise CommandError(f"'{name[:40]}' is no option of {_ENGINE}; those are {', '.join(known)}")
            try:
                one.set(world, handle, one.type.convert(value))
            except TypeError as problem:
                raise CommandError(f"'{name}' of 'dynamics.engineProperties' must be {problem}") from None

    return Property("dynamics.engineProperties", t.STRING, get, put)


_ENGINE = "mujoco"


def _options(text: str) -> dict[str, Any]:
    """Return the options of the engine in a text. Raises CommandError."""
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as problem:
        raise CommandError(f"'dynamics.engineProperties' is JSON: {problem}") from None
    engines = cast(dict[str, Any], found) if isinstance(found, dict) else {}
    options = engines.get(_ENGINE)
    if len(engines) != 1 or not isinstance(options, dict):
        raise CommandError(
            f"'dynamics.engineProperties' is a map with the key {_ENGINE}, the only engine here"
        )
    return cast(dict[str, Any], options)


def constant(name: str, kind: PropertyType, value: Any) -> Property:
    """Return a property that has one value and cannot be set."""
    return Property(name, kind, lambda _world, _handle: value)


_GREY, _BLACK, _DARK = Color.of((0.5, 0.5, 0.5)), Color.of((0, 0, 0)), Color.of((0.2, 0.2, 0.2))
