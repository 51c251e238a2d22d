"""Methods of every object: read, set, list and describe properties."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import Any

from simx_client.protocol.api2.objects import METHOD
from simx_server.errors import CommandError
from simx_server.sim_api.object_model import targets
from simx_server.sim_api.object_model.classes import super_classes
from simx_server.sim_api.object_model.tables.table import of_class
from simx_server.sim_api.object_model.targets import ModelTarget
from simx_server.sim_api.object_model.types import BY_NUMBER, MORE_NAMES, TYPES
from simx_server.sim_api.properties import access
from simx_server.sim_api.properties.property_types import PropertyType

from .method import Call, Options, groups_of_methods, method, methods_of, option, text_option, whole


def _target(call: Call) -> ModelTarget:
    return ModelTarget.of(call.world, call.handle, call.script)


def _asked(options: Options) -> PropertyType | None:
    """Return the type that the options name; None: that of the property."""
    if option(options, "type") is None:
        return None
    number = whole(options, "type", 0)
    found = BY_NUMBER.get(number)
    if found is None and number not in MORE_NAMES:
        raise CommandError(f"{number} is no type of properties; see sim.propertytype_*")
    return found


def _or_nil(options: Options, act: Callable[[], Any]) -> Any:
    """Return the result of an action; None where it fails and the options say `noError`."""
    try:
        return act()
    except CommandError:
        if option(options, "noError", False):
            return None
        raise


@method("object", "isValid", "reads")
def is_valid(_call: Call) -> bool:
    """Return true: for an object that does not exist the dispatcher answers."""
    return True


@method("object", "getProperty", "reads")
def get_property(call: Call, name: str, options: Options = None) -> Any:
    """Return a property, a method as its name."""
    if name in methods_of(_target(call).kind):
        return (name,)
    return (_or_nil(options, lambda: targets.read(_target(call), name, _asked(options))),)


@method("object", "setProperty", "changes", takes_values=True)
def set_property(call: Call, name: str, value: Any, options: Options = None) -> None:
    """Set a property; one that a program makes gets the type of the value, or the one in the options."""
    _or_nil(options, lambda: targets.write(_target(call), name, value, _asked(options)))


def _reader(kind: PropertyType) -> Callable[..., Any]:
    def read(call: Call, name: str, options: Options = None) -> Any:
        return (_or_nil(options, lambda: targets.read(_target(call), name, kind)),)

    return read


def _writer(kind: PropertyType) -> Callable[..., Any]:
    def write(call: Call, name: str, value: Any, options: Options = None) -> None:
        _or_nil(options, lambda: targets.write(_target(call), name, value, kind))

    return write


for _name, _kind in TYPES.items():
    method("object", f"get{_name}Property", "reads")(_reader(_kind))
    method("object", f"set{_name}Property", "changes", takes_values=True)(_writer(_kind))


@method("object", "getMethodProperty", "reads")
def get_method_property(call: Call, name: str, _options: Options = None) -> str:
    """Return the name of a method."""
    if name not in methods_of(_target(call).kind):
        raise CommandError(f"property is unknown: no method is called '{name[:40]}'")
    return name


@method("object", "setMethodProperty", "runs code")
def set_method_property(_call: Call, _name: str, _value: Any, _options: Options = None) -> None:
    """Refuse: a function of a program cannot become one of the server."""
    raise CommandError("methods cannot be made here: the server takes no compiled code")


@method("object", "getProperties", "reads")
def get_properties(call: Call, options: Options = None) -> dict[str, Any]:
    """Return the properties that can be read now, by name."""
    target, found = _target(call), dict[str, Any]()
    is_short = bool(option(options, "skipLarge", False))
    for name in access.names(target):
        try:
            _, flags = access.information(target, name) or (0, access.NOT_READABLE)
            if not (flags & access.NOT_READABLE or (flags & access.LARGE and is_short)):
                found[name] = targets.read(target, name, None)
        except CommandError:
            continue  # it has no value now, or a reason in its place
    return found


@method("object", "setProperties", "changes", takes_values=True)
def set_properties(call: Call, values: dict[str, Any]) -> None:
    """Set properties, by name, in the order of their names."""
    for name in sorted(values, key=str):
        targets.write(_target(call), str(name), values[name], None)


@method("object", "getPropertyName", "reads")
def get_property_name(call: Call, index: int, options: Options = None) -> tuple[str | None, str | None]:
    """Return the name of the property at an index from 0 and its class; twice nil after the last."""
    target = _target(call)
    prefix, excluded = text_option(options, "prefix"), whole(options, "excludeFlags", 0)
    names = [name for name in access.names(target) if name.startswith(prefix)]
    if excluded:
        names = [name for name in names if not (access.information(target, name) or (0, 0))[1] & excluded]
    if not 0 <= index < len(names):
        return None, None
    return names[index], _class_with(target.kind, names[index])


@cache
def _class_with(kind: str, name: str) -> str:
    """Return the class to which a property of objects of a class belongs."""
    found = next(
        (above for above in super_classes(kind) if above in _LISTED and name in _LISTED[above]()), None
    )
    return found or kind


_OBJECT = frozenset(("handle", "type", "objectType"))
_LISTED: Mapping[str, Callable[[], frozenset[str]]] = {
    "object": lambda: _OBJECT | {name for name in of_class("path") if name.startswith("metaInfo.")},
    "sceneObject": lambda: frozenset(of_class("path")),  # a class that adds no properties
}


@method("object", "getPropertyInfo", "reads")
def get_property_info(
    call: Call, name: str, options: Options = None
) -> tuple[int | None, int | None, str | None]:
    """Return type, flags and a description as JSON; with `noError` three times nil for an unknown name."""
    target = _target(call)
    kind = target.kind
    found = targets.information(target, name, methods_of(kind), groups_of_methods(kind))
    if found is not None:
        return (*found, json.dumps({"label": name}))
    if option(options, "noError", False):
        return None, None, None
    raise target.lacks(name)


@method("object", "setPropertyInfo", "changes")
def set_property_info(call: Call, name: str, _flags: int, _description: str) -> None:
    """Refuse: programs cannot describe properties."""
    if targets.information(_target(call), name, {}) is None:
        raise _target(call).lacks(name)
    raise CommandError("flags and descriptions of properties cannot be changed here")


@method("object", "getPropertyInfos", "reads")
def get_property_infos(call: Call, options: Options = None) -> dict[str, Any]:
    """Return type, flags and description of the properties and methods, by name."""
    target = _target(call)
    known = methods_of(target.kind)
    prefix = text_option(options, "prefix")
    found: dict[str, Any] = {}
    for name in [*access.names(target), *known]:
        if name.startswith(prefix) and (info := targets.information(target, name, known)) is not None:
            found[name] = _described(name, info, _class_with(target.kind, name))
    return found


@method("object", "getPropertiesInfos", "reads")
def get_properties_infos(call: Call, options: Options = None) -> dict[str, Any]:
    """Return the same: the older name."""
    return get_property_infos(call, options)


def _described(name: str, info: tuple[int, int], kind: str) -> dict[str, Any]:
    number, flags = info
    return {
        "type": number,
        "flags": {
            "value": flags,
            "readable": number != METHOD and not flags & access.NOT_READABLE,
            "writable": not flags & access.NOT_WRITABLE,
            "removable": bool(flags & access.REMOVABLE),
            "large": bool(flags & access.LARGE),
        },
        "class": kind,
        "label": name,
    }


@method("object", "getPropertyTypeString", "reads")
def get_property_type_string(_call: Call, number: int) -> str:
    """Return the name of a sim.propertytype_*."""
    found = BY_NUMBER.get(number)
    if found is not None:
        return found.name.lower()
    if number in MORE_NAMES:
        return MORE_NAMES[number]
    raise CommandError(f"{number} is no type of properties; see sim.propertytype_*")


@method("object", "removeProperty", "changes")
def remove_property(call: Call, name: str, options: Options = None) -> None:
    """Remove a property that a program has made."""
    _or_nil(options, partial(targets.remove, _target(call), name))
