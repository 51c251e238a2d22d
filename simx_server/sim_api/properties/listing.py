"""The list of all properties, for the page on what scripts can call."""

from __future__ import annotations

from collections.abc import Sequence

from .entry import Property
from .table import by_target

_HEAD = """\
## Properties

`sim.getFloatProperty(shape, 'mass')` and its like read the properties of CoppeliaSim 4.8 and later. The name of the
function contains the type. A target is an object, `sim.handle_scene` or `sim.handle_app`; programs may give each target
`customData.NAME` and `signal.NAME`, objects also `refs.NAME`, and `sim.handle_app` also `namedParam.NAME`."""


def as_markdown() -> str:
    """Return a section with a list for each kind of target."""
    return "\n\n".join([_HEAD, *(_section(target, found) for target, found in by_target().items())])


def _section(target: str, properties: Sequence[Property]) -> str:
    types = list(dict.fromkeys(each.type.name for each in properties))
    rows = [_row(name, [each for each in properties if each.type.name == name]) for name in types]
    return "\n".join([f"### {target[0].upper()}{target[1:]}", "", *rows])


def _row(name: str, properties: Sequence[Property]) -> str:
    both = [each.name for each in properties if each.get and each.set]
    read = [each.name for each in properties if each.set is None]
    only_set = [each.name for each in properties if each.get is None]
    groups = {"": both, "read only ": read, "set only ": only_set}
    return f"* {name}: {'; '.join(how + _names(names) for how, names in groups.items() if names)}"


def _names(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)
