"""Classes of a program's own, and windows: consoles and text editors."""

from __future__ import annotations

from html import escape
from typing import Any, cast

from simx_server.errors import CommandError
from simx_server.parts.user_interface.widgets import MAX_TEXT
from simx_server.parts.user_interface.xml_windows.reading import read_window
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.object_model import targets
from simx_server.sim_api.object_model.classes import is_class
from simx_server.sim_api.object_model.instances.custom import MOST_MEMBERS, CustomObject, class_named
from simx_server.sim_api.object_model.instances.windows import ConsoleInstance, EditorInstance
from simx_server.sim_api.object_model.tables.custom import EDITED, WINDOW_SETTINGS
from simx_server.sim_api.object_model.targets import ModelTarget
from simx_server.sim_api.object_model.values import Color, Ref, to_color

from .method import Call, Options, method, option, words

_INIT, _CLEANUP = "init", "cleanup"
"""Methods that are called for a new object, and before an object is removed."""


def _item(call: Call) -> CustomObject:
    return call.world.instances.get(call.handle, CustomObject)


def _new_class(call: Call, name: str) -> CustomObject:
    """Return a class that is not added yet. Raises CommandError: the name is taken, or no name."""
    if not name.isidentifier() or len(name) > 60:
        raise CommandError(f"'{name[:40]}' is no name of a class: it is a word of at most 60 characters")
    if is_class(name) or class_named(call.world, name) is not None:
        raise CommandError(f"there is a class '{name}' already")
    made = CustomObject(name)
    made.owner = call.script.signal_owner
    return made


@method("app", "createCustomObjectClass", "needs a script")
def create_class(call: Call, name: str, options: Options = None) -> Ref:
    """Make a class; its properties and methods are set as those of an object. Option `metaInfo`: `superClass` and
    `namespaces`, the groups to which programs may add properties. It ends with the script that made it.
    """
    made = _new_class(call, name)
    given = option(options, "metaInfo", {})
    if not isinstance(given, dict):
        raise CommandError("'metaInfo' is a map with superClass and namespaces")
    info = cast(dict[str, Any], given)
    supers = words(info, "superClass") or ["customObject"]
    made.supers = supers if supers[0] == "object" else ["object", *supers]
    made.spaces = words(info, "namespaces")
    return Ref(call.world.instances.add(made).handle)


@method("sceneObject", "makeClass", "needs a script")
def make_class(call: Call, name: str) -> Ref:
    """Make a class of this object with all below it, of which makeObject makes copies."""
    made = _new_class(call, name)
    target = ModelTarget.of(call.world, call.handle, call.script)
    made.is_base = targets.read(target, "modelBase", None)
    targets.write(target, "modelBase", True, None)
    try:
        content = call.sim.saveModel(call.handle)
    finally:
        targets.write(target, "modelBase", made.is_base, None)
    assert isinstance(content, bytes)
    made.model, made.supers = content, ["object", "sceneObject"]
    call.world.instances.resize(made, len(content))
    return Ref(call.world.instances.add(made).handle)


@method("sceneObject", "makeObject", "changes")
def make_object_of_object(call: Call) -> Ref:
    """Refuse: this object is not a class."""
    name = call.world.simulation.scene.get(call.handle).name
    raise CommandError(
        f"'{name}' is no class: makeClass makes one of it, or scene.duplicateObjects copies it"
    )


@method("customObject", "makeObject", "changes")
def make_object(call: Call, options: Options = None) -> Ref:
    """Make an object of this class. Options `appScope` (true at first: it belongs to the server, not to the scene),
    `scriptPersistent`: it outlives the script that makes it. Its method `init` is called.
    """
    template = _item(call)
    if not template.is_class:
        raise CommandError(f"this is an object of class {template.name}, and no class")
    if template.model:
        return _copy(call, template)
    made = template.new()
    made.in_app = bool(option(options, "appScope", True))
    made.owner = None if option(options, "scriptPersistent", False) else call.script.signal_owner
    call.world.instances.add(made)
    _call(made, _INIT)
    return Ref(made.handle)


def _copy(call: Call, template: CustomObject) -> Ref:
    handle = call.sim.loadModel(template.model)
    if not template.is_base:
        targets.write(ModelTarget.of(call.world, handle, call.script), "modelBase", False, None)
    template.members.add(handle)
    init = template.methods.get(_INIT)
    if init is not None:
        init(Ref(handle))
    return Ref(handle)


def _call(item: CustomObject, name: str) -> None:
    found = item.method(name)
    if found is not None:
        found(Ref(item.handle))


@method("customObject", "remove", "changes")
def remove(call: Call, _options: Options = None) -> None:
    """Remove an object, after its method `cleanup`; or a class, whose objects keep their methods."""
    item = _item(call)
    if not item.is_class:
        _call(item, _CLEANUP)
    call.world.instances.remove(item.handle)


@method("customObject", "setMethodProperty", "needs a script", takes_values=True)
def set_method(call: Call, name: str, function: Any, _options: Options = None) -> None:
    """Give a class a method: a function of this script, which gets the object first."""
    item = _item(call)
    if not item.is_class:
        raise CommandError("methods belong to classes: set it for the class of this object")
    if not isinstance(function, Function):
        raise CommandError("a method is a function of this script: the server takes no code")
    if not name.isidentifier() or len(name) > 100:
        raise CommandError(f"'{name[:40]}' is no name of a method")
    if name not in item.methods and len(item.methods) >= MOST_MEMBERS:
        raise CommandError(f"a class has at most {MOST_MEMBERS} methods")
    item.methods[name] = function


# --- windows -----------------------------------------------------------------------------------------

_LINES = 1000
_MAY_CLOSE = 4
"""Bit of the mode of a console."""


def _settings(fields: dict[str, Any]) -> dict[str, Any]:
    """Take the settings of a window out of the fields of a new object. Raises CommandError."""
    found: dict[str, Any] = {}
    for each in WINDOW_SETTINGS:
        value = fields.pop(each.name, None)
        if value is not None:
            try:
                found[each.name] = each.type.convert(value)
            except TypeError as problem:
                raise CommandError(f"'{each.name}' must be {problem}") from None
    return found


def new_console(call: Call, fields: dict[str, Any]) -> int:
    """Open a console and return its handle in API 2."""
    settings = _settings(fields)
    background = settings.get("background", Color.of((1, 1, 1)))
    ink = settings.get("defaultColor", Color.of((0, 0, 0)))
    window = call.sim.auxiliaryConsoleOpen(
        str(settings.setdefault("title", "console")),
        _LINES,
        _MAY_CLOSE if settings.get("closeable", True) else 0,
        [int(settings.get(f"position.{axis}", 50)) for axis in "xy"],
        [int(settings.get("size.width", 800)), int(settings.get("size.height", 600))],
        ink.parts,
        background.parts,
    )
    consoles = call.world.user_interface.consoles
    made = ConsoleInstance(window, settings, lambda: consoles.close(window))
    made.owner = call.script.signal_owner
    return call.world.instances.add(made).handle


def new_editor(call: Call, fields: dict[str, Any]) -> int:
    """Open a text editor and return its handle in API 2."""
    settings = _settings(fields)
    title = escape(str(settings.setdefault("title", "editor")))
    text = fields.pop("text", "")
    window = read_window(
        f'<ui title="{title}" closeable="false"><text-browser id="{EDITED}" read-only="false"/></ui>'
    )
    window.widget(EDITED).text = (text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text))[
        :MAX_TEXT
    ]
    (handle,) = call.world.user_interface.windows.add(window)
    windows = call.world.user_interface.windows
    made = EditorInstance(handle, settings, lambda: windows.remove(handle))
    made.owner = call.script.signal_owner
    return call.world.instances.add(made).handle


def _console(call: Call) -> ConsoleInstance:
    return call.world.instances.get(call.handle, ConsoleInstance)


@method("console", "print", "changes", takes_values=True)
def print_text(call: Call, text: str, color: Any = None) -> None:
    """Append text. Its colour is that of the whole console: `color` is checked only."""
    console = _console(call)
    if color is not None:
        to_color(color)
    call.sim.auxiliaryConsolePrint(console.window, text)
    console.text = (console.text + text)[-MAX_TEXT:]


@method("console", "clear", "changes")
def clear(call: Call) -> None:
    """Remove the text."""
    console = _console(call)
    call.sim.auxiliaryConsolePrint(console.window)
    console.text = ""


@method("console", "remove", "changes")
def remove_console(call: Call, _options: Options = None) -> None:
    """Close a console."""
    call.world.instances.remove(_console(call).handle)


@method("textEditor", "remove", "changes")
def remove_editor(call: Call, _options: Options = None) -> None:
    """Close a text editor."""
    call.world.instances.remove(call.world.instances.get(call.handle, EditorInstance).handle)
