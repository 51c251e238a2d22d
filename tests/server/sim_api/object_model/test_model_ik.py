"""The classes IK, IKGroup, IKElement, IKObject and IKJoint of API 2."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from model_world import ARM, Model

from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.sim_api.object_model.values import Matrix, Pose, Quaternion, Ref

POSITION = 5
"""x and z: all that the arm can choose."""


@pytest.fixture
def model(tmp_path: Path) -> Model:
    return Model(ARM, workspace=tmp_path)


def group_of(model: Model, **options: Any) -> tuple[Ref, Ref, Ref]:
    """Return a world, its group, and the element of the arm."""
    world = model.do("app", "IK")
    group = model.do(world, "createGroup", {"maxIterations": 50, **options})
    ends = (model.at("/base"), model.at("/base/shoulder/upper/elbow/lower/tip"), model.at("/target"))
    return world, group, model.do(group, "addElementFromScene", *ends, POSITION)


def place_of(model: Model, path: str) -> list[float]:
    return model.do(path, "getPosition").numbers


TIP = "/base/shoulder/upper/elbow/lower/tip"


def test_a_group_moves_the_arm_to_its_target(model: Model) -> None:
    _, group, _ = group_of(model)
    solved, flags, precision = model.do(group, "solve")
    assert (solved, flags) == (True, 0)
    assert precision[0] < 1e-3
    assert place_of(model, TIP) == pytest.approx([0.5, 0, 0.6], abs=1e-3)


def test_a_world_is_solved_apart_from_the_scene(model: Model) -> None:
    world, group, element = group_of(model)
    before = place_of(model, TIP)
    solved, _, _, values, joints = model.do(world, "solve", {"syncWorlds": False, "returnExtras": True})
    assert solved
    assert place_of(model, TIP) == before
    tip = model.get(element, "tip")
    assert model.do(tip, "getPosition").numbers == pytest.approx([0.5, 0, 0.6], abs=1e-3)
    assert [each["touched"] for each in joints] == [True, True]
    assert [model.get(each["joint"], "jointPosition") for each in joints] == values.numbers
    model.do(group, "syncToScene")
    assert place_of(model, TIP) == pytest.approx([0.5, 0, 0.6], abs=1e-3)
    model.do("/target", "setPosition", Matrix.vector([0.3, 0, 0.5]))
    model.do(world, "syncFromScene")
    assert model.do(model.get(element, "target"), "getPosition").numbers == pytest.approx([0.3, 0, 0.5])


def test_a_target_out_of_reach_leaves_the_arm(model: Model) -> None:
    _, group, _ = group_of(model)
    before = place_of(model, TIP)
    model.do("/target", "setPosition", Matrix.vector([2, 0, 2]))
    solved, flags, precision = model.do(group, "solve")
    assert not solved
    assert flags & 16
    assert precision[0] > 1
    assert place_of(model, TIP) == before
    assert model.do(group, "solve", {"ignoreTolerance": True})[0]
    assert place_of(model, TIP) != before


def test_objects_joints_and_elements_are_described(model: Model) -> None:
    world, group, element = group_of(model, method="dampedLeastSquares", damping=0.2)
    objects, joints = model.get(world, "objects"), model.get(world, "joints")
    shoulder = model.at("/base/shoulder").handle
    assert joints[shoulder] == objects[shoulder]
    assert model.get(joints[shoulder], "type") == "joint"
    assert model.get(joints[shoulder], "objectType") == "IKJoint"
    assert model.get(joints[shoulder], "jointType") == "revolute"
    assert model.get(joints[shoulder], "bounds") == [-7.0, 7.0]
    assert model.get(model.get(element, "base"), "type") == "dummy"
    assert model.get(element, "jointList") == [
        joints[shoulder],
        joints[model.at("/base/shoulder/upper/elbow").handle],
    ]
    assert model.get(world, "groupList") == [group]
    assert model.get(group, "elementList") == [element]
    assert [model.get(group, name) for name in ("method", "damping", "maxIterations")] == [
        "dampedLeastSquares",
        0.2,
        50,
    ]
    assert model.get(element, "constraints") == POSITION
    for name, value in (("precision", [0.01, 0.02]), ("weights", [1.0, 0.5])):
        model.set(element, name, value)
        assert model.get(element, name) == value


def test_settings_of_joints_count_in_solutions(model: Model) -> None:
    world, group, _ = group_of(model)
    elbow = model.get(world, "joints")[model.at("/base/shoulder/upper/elbow").handle]
    for name, value in (("weight", 0.5), ("limitMargin", 0.1), ("maxStepSize", 0.2), ("jointPosition", 0.3)):
        model.set(elbow, name, value)
        assert model.get(elbow, name) == value
    model.set(elbow, "passive", True)
    model.do(group, "solve", {"syncWorlds": False})
    assert model.get(elbow, "jointConfiguration") == [0.3]
    model.set(group, "enabled", False)
    with pytest.raises(CommandError, match="nothing to solve"):
        model.do(group, "solve")


def test_targets_have_poses_of_their_own(model: Model) -> None:
    _, group, element = group_of(model)
    target = model.get(element, "target")
    model.do(target, "setPose", Pose([0.4, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]))
    model.do(target, "setPosition", Matrix.vector([0.3, 0, 0.6]))
    model.do(target, "setQuaternion", Quaternion([0.0, 0.0, 1.0, 0.0]))
    assert model.do(target, "getPose").numbers == pytest.approx([0.3, 0, 0.6, 0, 0, 1, 0])
    base = model.get(element, "base")
    assert model.do(target, "getPosition", {"relativeToObject": base}).numbers == pytest.approx([0.3, 0, 0.6])
    assert model.do(group, "solve", {"syncWorlds": False})[0]
    assert model.do(model.get(element, "tip"), "getPosition").numbers == pytest.approx(
        [0.3, 0, 0.6], abs=1e-3
    )
    assert place_of(model, "/target") == [0.5, 0, 0.6]


def test_configurations_are_searched_for_poses(model: Model) -> None:
    _, group, _ = group_of(model)
    pose = Pose([0.2, 0.0, 0.7, 0.0, 0.0, 0.0, 1.0])
    found, joints = model.do(group, "findConfig", [pose])
    assert (found.rows, found.columns, len(joints)) == (2, 1, 2)
    for each, value in zip(joints, found.numbers, strict=True):
        model.set(each["joint"], "jointPosition", value)
    model.do(group, "syncToScene")
    assert place_of(model, TIP) == pytest.approx([0.2, 0, 0.7], abs=1e-3)
    many, _ = model.do(group, "findConfig", [pose], {"altConfigs": True})
    assert many.columns >= 2
    none, _ = model.do(group, "findConfig", [pose], {"callback": lambda *_: [None], "maxTime": 0.01})
    assert none is None
    with pytest.raises(CommandError, match="as many poses"):
        model.do(group, "findConfig", [])


def test_a_world_goes_with_all_that_is_in_it(model: Model) -> None:
    world, group, element = group_of(model)
    target = model.get(element, "target")
    model.do(world, "remove")
    for each in (world, group, element, target):
        assert not model.do(each, "isValid")
    with pytest.raises(CommandError, match="does not exist"):
        model.do(group, "solve")


def test_bad_elements_are_refused_and_leave_nothing(model: Model) -> None:
    world = model.do("app", "IK")
    group = model.do(world, "createGroup")
    tip, target, apart = (model.at(each) for each in (TIP, "/target", "/other"))
    for ends, bits, problem in (
        ((apart, tip, target), 7, "not above"),
        ((None, target, tip), 7, "joint"),
        ((None, tip, target), 99, "constraint"),
        ((None, tip, Ref(99)), 7, "99"),
    ):
        with pytest.raises(CommandError, match=problem):
            model.do(group, "addElementFromScene", *ends, bits)
    assert model.get(group, "elementList") == []
    with pytest.raises(CommandError, match="no method"):
        model.do(world, "createGroup", {"method": "newton"})
    assert model.get(world, "groupList") == [group]


def test_the_number_of_worlds_has_a_limit(tmp_path: Path) -> None:
    model = Model(ARM, workspace=tmp_path)
    model.parts.simulation.limits = Limits.of(["instances=3"])
    for _ in range(3):
        model.do("app", "IK")
    with pytest.raises(CommandError, match="instances"):
        model.do("app", "IK")
