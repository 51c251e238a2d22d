"""How much of CoppeliaSim 4.11's object model is there, property by property and method by method."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.object_model.classes import SCENE_OBJECTS
from simx_server.sim_api.object_model.dispatch import methods
from simx_server.sim_api.object_model.tables.detached_scripts import detached_script
from simx_server.sim_api.object_model.tables.making import Refused
from simx_server.sim_api.object_model.tables.table import of_class, with_object
from simx_server.sim_api.properties.entry import Property

LISTS = Path(__file__).parents[3] / "support" / "manual"

IN_LUA = {"RuckigPosition", "RuckigVelocity", "MoveToConfig", "MoveToPose", "TimeOptimalTrajectory"}
"""Classes of the module Motion; `tests/server/scripting/modules/test_sim_2.py` compares their methods."""


def listed(file: str) -> Iterator[tuple[str, str]]:
    """Return class and name of each entry."""
    lines = (LISTS / f"{file}.txt").read_text().splitlines()
    kind = ""
    for word in " ".join(line for line in lines if not line.startswith("#")).split():
        if word.startswith("["):
            kind = word.strip("[]")
        else:
            yield kind, word


def table(kind: str) -> dict[str, Property]:
    if kind == "detachedScript":
        return dict(with_object(kind, detached_script(Script(1, ScriptKind.CHILD, -1, "text"))))
    if kind == "drawingObject":
        return dict(of_class("marker"))
    return dict(of_class({"object": "path", "sceneObject": "path", "mesh": "shape"}.get(kind, kind)))


def test_nine_of_ten_properties_of_the_model_are_there_and_the_others_have_a_reason() -> None:
    entries = [(kind, *word.split(":")) for kind, word in listed("api2_properties")]
    assert len(entries) > 450
    missing = [f"{kind}.{name}" for kind, name, _ in entries if name not in table(kind)]
    assert not missing
    refused = [f"{kind}.{name}" for kind, name, _ in entries if isinstance(table(kind)[name], Refused)]
    assert len(refused) <= 0.1 * len(entries), refused


OTHER_TYPES = {"primitive"}
"""A shape stands for its mesh; of both `primitive` is the shape's, a boolean."""


def test_the_properties_have_the_types_of_the_model() -> None:
    wrong = {
        f"{kind}.{name}": (kind_of, table(kind)[name].type.name.lower())
        for kind, name, kind_of in ((kind, *word.split(":")) for kind, word in listed("api2_properties"))
        if name in table(kind)
        and table(kind)[name].type.name.lower() != kind_of
        and not (kind == "mesh" and name in OTHER_TYPES)
    }
    assert not wrong


def test_every_method_of_the_model_is_there() -> None:
    entries = list(listed("api2_methods"))
    of = {
        "sceneObject": "joint",
        "object": "joint",
        "mesh": "shape",
        "Console": "console",
        "TextEditor": "textEditor",
    }
    missing = {
        f"{kind}.{name}"
        for kind, name in entries
        if kind not in IN_LUA
        and not (name in CONSTRUCTORS and kind in ("Path", "IK"))
        and name not in methods(of.get(kind, kind))
    }
    assert missing <= WRITTEN_IN_LUA
    assert len(entries) == 283
    assert {"Path", "IK", *(f"Path.{name}" for name in CONSTRUCTORS if name != "Constructor")} <= methods(
        "app"
    ).keys()


CONSTRUCTORS = ("Constructor", "fromBuffer", "fromJoints", "fromObject")
"""Methods of the server here, such as `Path.fromBuffer`."""

WRITTEN_IN_LUA = {
    "app.throttle",
    "detachedScript.registerFunctionHook",
    "detachedScript.removeFunctionHook",
    "detachedScript.getFunctions",
}
"""Methods of the module ``sim-2``, which need the script's own functions."""


@pytest.mark.parametrize(
    "kind",
    [
        *SCENE_OBJECTS,
        *("app", "scene", "collection", "marker", "Path", "IK", "IKGroup", "IKJoint", "console"),
    ],
)
def test_every_method_declares_what_it_does(kind: str) -> None:
    for name, method in methods(kind).items():
        assert method.name == name
        assert method.effect in ("reads", "takes", "changes", "writes files", "runs code", "needs a script")
