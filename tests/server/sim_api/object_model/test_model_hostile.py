"""Every method with arguments that no program means: each fails with a reason, or does what it can."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from model_world import Model
from seeds import seeds
from sim_api_calls import SCENE

from simx_server.errors import CommandError
from simx_server.sim_api.object_model.dispatch import methods
from simx_server.sim_api.object_model.tables.table import of_class
from simx_server.sim_api.object_model.values import Color, Matrix, Pose, Quaternion, Ref

VALUES: list[Any] = [
    None, True, 0, -1, 7, 1 << 40, 0.5, -3.0, float("nan"), float("inf"), "", "position", "/cube", "customData.x", b"",
    b"\0\xff" * 12, [], [1.0, 2.0, 3.0], [0.0] * 7, ["joint"], [[1, 2], [3, 4]], {}, {"noError": True},
    {"type": "shape"}, {"closed": True}, {"types": ["ang"], "bounds": [[0, 1]]}, {"metric": [1], "ctrlPoints": 3},
    {"section": [[0, 1]], "axis": 9}, {"returnExtras": True, "ignoreTolerance": True}, {"maxTime": 1e9, "callback": 3},
    {"type": "dummy"}, {"size": "x"}, {"position": [1, "a"]}, {"relativeToObject": "no"}, {"color": "x"}, Ref(-1),
    Ref(1), Ref(99999), Matrix(3, 1, [1.0, 2.0, 3.0]), Matrix(3, 3, [1.0] * 9), Matrix(0, 0, []), Color(b"\1\2\3\4"),
    Pose([0.0] * 6 + [1.0]), Quaternion([0.0] * 4),
]  # fmt: skip

ENDING = {"quit", "remove", "loadScene", "loadSceneFromBuffer", "removeObjects", "removeModel"}
"""Methods that would leave nothing to try the others on."""

WAITING = {"step", "yield", "wait", "systemLock", "checkSensor", "handleSensor", "getImage", "getDepth"}
"""Methods that wait, also for images, of which this world has none."""


def made(model: Model) -> list[tuple[str, int]]:
    """Return classes and handles of objects beside the scene."""
    path = model.do("app", "Path", Matrix(3, 2, [0, 1, 0, 0, 0, 0]))
    world = model.do("app", "IK")
    group = model.do(world, "createGroup")
    ends = (model.at("/robot"), model.at("/robot/hinge/arm/tip"), model.at("/robot/mark"))
    element = model.do(group, "addElementFromScene", *ends, 7)
    (joint,) = model.get(element, "jointList")
    own = model.do("app", "createCustomObjectClass", "own")
    console = model.do("app", "createObject", {"type": "console"})
    editor = model.do("app", "createObject", {"type": "textEditor"})
    found = [("Path", path), ("IK", world), ("IKGroup", group), ("IKElement", element), ("IKJoint", joint)]
    found += [("IKObject", model.get(element, "target")), ("customObject", own), ("console", console)]
    return [(kind, each.handle) for kind, each in [*found, ("textEditor", editor)]]


@pytest.mark.parametrize("seed", seeds(4))
def test_no_arguments_fail_inside_the_server(tmp_path: Path, seed: int) -> None:
    model, draw = Model(SCENE, workspace=tmp_path), random.Random(seed)
    group = model.do("scene", "createObject", {"type": "collection"})
    marker = model.do("scene", "createObject", {"type": "marker"})
    cloud = model.do("scene", "createObject", {"type": "pointCloud"})
    tree = model.do("scene", "createObject", {"type": "ocTree"})
    targets = [
        ("scene", -12), ("app", -13), ("shape", model.at("/wall").handle), ("joint", model.at("/robot/hinge").handle),
        ("dummy", model.at("/robot/mark").handle), ("proximitySensor", model.at("/ray").handle),
        ("collection", group.handle), ("marker", marker.handle), ("pointCloud", cloud.handle), ("ocTree", tree.handle),
        ("detachedScript", model.script.handle), *made(model),
    ]  # fmt: skip
    for kind, handle in targets:
        for name in sorted(set(methods(kind)) - ENDING - WAITING):
            arguments = draw.choices(VALUES, k=draw.randrange(4))
            try:
                found = model.do(handle, name, *arguments)
                if hasattr(found, "close"):
                    found.close()
            except CommandError:
                continue
            except Exception as problem:
                pytest.fail(f"{kind}.{name}{arguments}: {type(problem).__name__}: {problem}")


@pytest.mark.parametrize(
    "value",
    [
        '{"@":"buffer","value":99999999999}',
        '{"@":"color","value":[]}',
        '{"@":"color","value":[1,2,3,4,5]}',
        '{"@":"matrix","value":[1,1,[1e999]]}',
        '{"@":"pose","value":[' + ",".join(["9" * 400] * 7) + "]}",
        '{"@":"object","value":1e999}',
    ],
)
def test_texts_that_stand_for_no_value_are_refused(tmp_path: Path, value: str) -> None:
    model = Model(SCENE, workspace=tmp_path)
    with pytest.raises(CommandError, match="must be a value of the module sim-2"):
        model.do("app", "deserialize", value.encode())


def test_no_properties_of_made_objects_fail_inside_the_server(tmp_path: Path) -> None:
    model = Model(SCENE, workspace=tmp_path)
    for kind, handle in made(model):
        for name in of_class(kind):
            for value in VALUES:
                try:
                    model.get(handle, name)
                    model.set(handle, name, value)
                except CommandError:
                    continue
                except Exception as problem:
                    pytest.fail(f"{kind}.{name} = {value!r}: {type(problem).__name__}: {problem}")
