"""Classes of a program's own, consoles and text editors."""

from __future__ import annotations

from typing import Any

import pytest
from model_world import Model, model

from simx_server.errors import CommandError
from simx_server.sim_api.object_model.values import Color, Matrix, Ref

__all__ = ["model"]


class Method:
    """A function of a script."""

    def __init__(self, *results: Any) -> None:
        self.results, self.calls = list(results), list[tuple[Any, ...]]()

    def __call__(self, *arguments: Any) -> list[Any]:
        self.calls.append(arguments)
        return self.results


@pytest.fixture
def robot(model: Model) -> Ref:
    """Return a class."""
    made = model.do("app", "createCustomObjectClass", "robot", {"metaInfo": {"namespaces": ["log"]}})
    model.do(made, "setFloatProperty", "speed", 0.5)
    model.do(made, "setColorProperty", "paint.color", [1.0, 0.0, 0.0])
    return made


def test_objects_start_with_the_properties_of_their_class(model: Model, robot: Ref) -> None:
    first, second = (
        model.do(robot, "makeObject"),
        model.do("app", "createObject", {"type": "robot", "speed": 2}),
    )
    assert model.get(first, "speed") == 0.5
    assert model.get(second, "speed") == 2.0
    assert model.get(first, "paint.color") == Color(b"\xff\x00\x00\xff")
    model.set(first, "speed", 3)
    assert model.get(robot, "speed") == 0.5
    assert model.get(first, "type") == "robot"
    assert [model.get(each, "metaInfo.isClass") for each in (robot, first)] == [True, False]
    assert model.get(first, "metaInfo.superClass") == ["object", "customObject"]
    assert model.get("app", "customClasses") == [robot]
    assert model.get("app", "customObjects") == [first, second]
    with pytest.raises(CommandError, match="type float"):
        model.do(first, "setStringProperty", "speed", "fast")
    with pytest.raises(CommandError, match="unknown"):
        model.set(first, "height", 1)
    model.set(first, "log.note", "hello")
    assert model.get(first, "log.note") == "hello"
    model.do(first, "removeProperty", "log.note")
    assert model.do(first, "getProperty", "log.note", {"noError": True}) == (None,)


def test_objects_belong_to_the_server_or_to_the_scene(model: Model, robot: Ref) -> None:
    made = model.do(robot, "makeObject", {"appScope": False})
    assert model.get("scene", "customObjects") == [made]
    assert model.get("app", "customObjects") == []


def test_methods_get_the_object_and_its_values(model: Model, robot: Ref) -> None:
    drive, init, cleanup = Method(Matrix.vector([1, 2])), Method(), Method()
    for name, function in (("drive", drive), ("init", init), ("cleanup", cleanup)):
        model.do(robot, "setMethodProperty", name, function)
    made = model.do(robot, "makeObject")
    assert init.calls == [(made,)]
    assert model.do(made, "drive", model.at("/cube"), 0.5) == (Matrix.vector([1, 2]),)
    assert drive.calls == [(made, model.at("/cube"), 0.5)]
    assert model.do(made, "getPropertyInfo", "drive")[0] == 240
    model.do(made, "remove")
    assert cleanup.calls == [(made,)]
    assert not model.do(made, "isValid")
    with pytest.raises(CommandError, match="no method"):
        model.do(robot, "fly")


def test_methods_read_and_set_properties(model: Model, robot: Ref) -> None:
    model.do(robot, "setMethodProperty", "speed_get_", Method(7.0))
    setter = Method(9.0)
    model.do(robot, "setMethodProperty", "speed_set_", setter)
    made = model.do(robot, "makeObject")
    assert model.get(made, "speed") == 7.0
    model.set(made, "speed", 8)
    assert setter.calls == [(made, "speed", 8.0)]
    model.do(robot, "setMethodProperty", "speed_get_", Method("much"))
    with pytest.raises(CommandError, match="must return"):
        model.get(made, "speed")


def test_classes_are_made_of_scene_objects(model: Model) -> None:
    post = model.do("/wall", "makeClass", "post")
    wave = Method("hello")
    model.do(post, "setMethodProperty", "wave", wave)
    made = model.do(post, "makeObject")
    assert model.get(made, "type") == "shape"
    assert model.get(made, "modelBase") == model.get("/wall", "modelBase")
    assert model.do(made, "wave") == ("hello",)
    assert model.get("app", "customSceneObjectClasses") == [post]
    with pytest.raises(CommandError, match="no class"):
        model.do("/wall", "makeObject")


def test_bad_classes_are_refused(model: Model, robot: Ref) -> None:
    for name in ("robot", "shape", "two words", ""):
        with pytest.raises(CommandError, match=r"class"):
            model.do("app", "createCustomObjectClass", name)
    with pytest.raises(CommandError, match="takes no code"):
        model.do(robot, "setMethodProperty", "run", b"\x1bLua")
    made = model.do(robot, "makeObject")
    with pytest.raises(CommandError, match="belong to classes"):
        model.do(made, "setMethodProperty", "run", Method())
    with pytest.raises(CommandError, match="no class"):
        model.do(made, "makeObject")


def test_custom_objects_end_with_their_script(model: Model, robot: Ref) -> None:
    made = model.do(robot, "makeObject")
    lasting = model.do(robot, "makeObject", {"scriptPersistent": True})
    model.parts.simulation.parts.tell(lambda part: part.script_ended(model.script.signal_owner))
    assert [model.do(each, "isValid") for each in (robot, made, lasting)] == [False, False, True]
    assert model.get(lasting, "speed") == 0.5


def test_consoles_print(model: Model) -> None:
    console = model.do("app", "createObject", {"type": "console", "title": "log", "size.width": 300})
    model.do(console, "print", "one\n")
    model.do(console, "print", "two", Color.of((1, 0, 0)))
    assert model.get(console, "text") == "one\ntwo"
    (shown,) = model.parts.user_interface.consoles
    assert (shown.title, shown.lines) == ("log", ["one", "two"])
    assert model.get(console, "visible")
    model.set(console, "visible", False)
    assert not model.get(console, "visible")
    assert model.get(console, "size.width") == 300
    model.do(console, "clear")
    assert model.get(console, "text") == ""
    model.do(console, "remove")
    assert not list(model.parts.user_interface.consoles)


def test_text_editors_hold_a_text(model: Model) -> None:
    editor = model.do("app", "createObject", {"type": "textEditor", "title": 'a "b" <c>', "text": "first"})
    assert model.get(editor, "text") == "first"
    (window,) = model.parts.user_interface.windows
    assert window.title == 'a "b" <c>'
    window.enter(1, "typed by a person")
    assert model.get(editor, "text") == "typed by a person"
    model.set(editor, "text", "set")
    model.set(editor, "visible", False)
    assert not model.get(editor, "visible")
    model.do(editor, "remove")
    assert not list(model.parts.user_interface.windows)
