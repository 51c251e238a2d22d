"""Properties of objects of a program's own classes, and of consoles and text editors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.parts.user_interface.widgets import MAX_TEXT
from simx_server.sim_api.object_model.instances.custom import CustomObject
from simx_server.sim_api.object_model.instances.windows import ConsoleInstance, EditorInstance, WindowInstance
from simx_server.sim_api.object_model.types import COLOR
from simx_server.sim_api.object_model.values import Color, Ref
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed
from simx_server.sim_api.properties.property_types import PropertyType

if TYPE_CHECKING:
    from simx_server.scripting.interpreter import Function
    from simx_server.world.world import World


def _custom(world: World, handle: int) -> CustomObject:
    return world.instances.get(handle, CustomObject)


CUSTOM_OBJECT = (
    Property("metaInfo.isClass", t.BOOL, lambda world, handle: _custom(world, handle).is_class),
    Property(
        "metaInfo.namespaces", t.STRING_ARRAY, lambda world, handle: list(_custom(world, handle).spaces)
    ),
    Property(
        "metaInfo.superClass", t.STRING_ARRAY, lambda world, handle: list(_custom(world, handle).supers)
    ),
)


def own_properties(item: CustomObject) -> tuple[Property, ...]:
    """Return the properties that a program has given to a class or an object, after those that all have."""
    return (*CUSTOM_OBJECT, *(_own(item, name, kind) for name, (kind, _) in item.values.items()))


def _own(item: CustomObject, name: str, kind: PropertyType) -> Property:
    def read(_world: World, _handle: int) -> Any:
        value = item.values[name][1]
        getter = None if item.is_class else item.method(f"{name}_get_")
        return value if getter is None else _answer(name, kind, getter, Ref(item.handle), name, value)

    def write(world: World, _handle: int, value: Any) -> None:
        setter = None if item.is_class else item.method(f"{name}_set_")
        if setter is not None:
            value = _answer(name, kind, setter, Ref(item.handle), name, value)
        item.put(world, name, kind, value)

    return Property(name, kind, read, write)


def _answer(name: str, kind: PropertyType, function: Function, *arguments: Any) -> Any:
    """Return what a method of a class makes of a property's value."""
    results = function(*arguments)
    try:
        return kind.convert(results[0] if results else None)
    except TypeError as problem:
        raise CommandError(f"the method for the property '{name}' must return {problem}") from None


# --- windows -----------------------------------------------------------------------------------------


def _setting(name: str, kind: PropertyType, first: Any) -> Property:
    """Return a setting with which a window was opened."""

    def get(world: World, handle: int) -> Any:
        return world.instances.get(handle, WindowInstance).settings.get(name, first)

    return Property(name, kind, get)


WINDOW_SETTINGS: tuple[Property, ...] = (
    _setting("background", COLOR, Color.of((1, 1, 1))),
    _setting("defaultColor", COLOR, Color.of((0, 0, 0))),
    _setting("size.width", t.INT, 800),
    _setting("size.height", t.INT, 600),
    _setting("position.x", t.INT, 50),
    _setting("position.y", t.INT, 50),
    _setting("closeable", t.BOOL, True),
    _setting("resizable", t.BOOL, True),
    _setting("fontSize", t.INT, 12),
    _setting("sceneUid", t.INT, -1),
    _setting("title", t.STRING, ""),
)
"""Settings of a window with their first values."""


def _console(world: World, handle: int) -> ConsoleInstance:
    return world.instances.get(handle, ConsoleInstance)


def _console_is_visible(world: World, handle: int) -> bool:
    found = world.user_interface.consoles.find(_console(world, handle).window)
    return found is not None and world.user_interface.consoles.is_visible(found)


def _show_console(world: World, handle: int, shown: bool) -> None:
    world.user_interface.consoles.show(_console(world, handle).window, shown)


CONSOLE = (
    Property("visible", t.BOOL, _console_is_visible, _show_console),
    fixed("hiddenInSimulation", t.BOOL, False, "a window stays visible while the simulation runs"),
    Property("text", t.STRING, lambda world, handle: _console(world, handle).text),
    *WINDOW_SETTINGS,
)


def _editor(world: World, handle: int) -> Any:
    return world.user_interface.windows.get(world.instances.get(handle, EditorInstance).window)


def _show_editor(world: World, handle: int, shown: bool) -> None:
    _editor(world, handle).is_visible = shown


def _set_text(world: World, handle: int, text: str) -> None:
    _editor(world, handle).widget(EDITED).text = text[:MAX_TEXT]


EDITED = 1
"""Number of the text in the window of an editor."""

TEXT_EDITOR = (
    Property("visible", t.BOOL, lambda world, handle: _editor(world, handle).is_visible, _show_editor),
    fixed("hiddenInSimulation", t.BOOL, False, "a window stays visible while the simulation runs"),
    Property("text", t.STRING, lambda world, handle: _editor(world, handle).widget(EDITED).text, _set_text),
    *WINDOW_SETTINGS,
)
