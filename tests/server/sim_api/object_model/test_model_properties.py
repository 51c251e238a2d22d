"""Properties of API 2: types, names, groups, and values that programs set."""

from __future__ import annotations

import json
from typing import Any

import pytest
from model_world import Model, model

from simx_server.errors import CommandError
from simx_server.sim_api.object_model.values import Color, Matrix, Pose, Quaternion, Ref

__all__ = ["model"]


def test_positions_are_matrices_of_one_column_in_the_frame_of_the_parent(model: Model) -> None:
    assert model.get("/cube", "position") == Matrix(3, 1, [2.0, 0.0, 1.0])
    arm, hinge = model.at("/robot/hinge/arm"), model.at("/robot/hinge")
    assert model.get(arm, "parent") == hinge
    assert model.get(arm, "position").numbers == [0.0, 0.0, 0.0]
    assert model.get(arm, "worldPosition").numbers == pytest.approx([0.0, 0.0, 1.3])
    model.set("/cube", "position", Matrix.vector([1, 2, 3]))
    model.set("/cube", "quaternion", [0.0, 0.0, 1.0, 0.0])
    assert model.get("/cube", "pose") == Pose([1.0, 2.0, 3.0, 0.0, 0.0, 1.0, 0.0])
    assert model.get("/cube", "quaternion") == Quaternion([0.0, 0.0, 1.0, 0.0])


def test_a_client_learns_the_groups_of_an_object_before_anything_else(model: Model) -> None:
    assert model.get("scene", "metaInfo.namespaces") == ["customData", "signal"]
    assert model.get("app", "metaInfo.namespaces") == ["customData", "signal", "namedParam"]
    assert model.get("/cube", "metaInfo.namespaces") == ["customData", "signal", "refs"]
    assert model.get("/cube", "metaInfo.superClass") == ["object", "sceneObject"]
    assert model.get("/cube", "type") == model.get("/cube", "objectType") == "shape"
    assert model.get("/cube", "metaInfo.isSceneObject")
    assert not model.get("scene", "metaInfo.isSceneObject")


@pytest.mark.parametrize(
    ("target", "name", "kind"),
    [
        ("scene", "getObject", 240),
        ("scene", "simulation", 24),
        ("scene", "simulation.start", 240),
        ("scene", "simulation.state", 25),
        ("scene", "dynamics.mujoco", 24),
        ("/cube", "position", 5),
        ("/cube", "applyColor.diffuse", 26),
        ("/cube", "inertiaMatrix", 18),
        ("/cube", "customData", 24),
        ("/cube", "parent", 21),
        ("/cube", "handle", 16),
        ("/robot/hinge", "joint.type", 3),
    ],
)
def test_information_names_the_type(model: Model, target: str, name: str, kind: int) -> None:
    assert model.do(target, "getPropertyInfo", name)[0] == kind


def test_unknown_names_give_as_many_nils_as_clients_unpack(model: Model) -> None:
    assert model.do("/cube", "getPropertyInfo", "bla", {"noError": True}) == (None, None, None)
    assert model.do("/cube", "getPropertyName", 100_000) == (None, None)
    with pytest.raises(CommandError, match=r"property is unknown.*did you mean 'position'"):
        model.do("/cube", "getPropertyInfo", "positon")
    with pytest.raises(CommandError, match="property is unknown"):
        model.get("/cube", "objectHandles")
    assert model.do("/cube", "getProperty", "nonsense", {"noError": True}) == (None,)


def test_old_names_are_invisible(model: Model) -> None:
    for old in ("alias", "absPosition", "calcLinearVelocity", "inertia", "modelNotVisible"):
        assert model.do("/cube", "getPropertyInfo", old, {"noError": True}) == (None, None, None)


def test_names_are_listed_with_their_class(model: Model) -> None:
    found: dict[str, str] = {}
    while (pair := model.do("/cube", "getPropertyName", len(found)))[0] is not None:
        found[pair[0]] = pair[1]
    assert found["mass"] == "shape"
    assert found["position"] == "sceneObject"
    assert found["metaInfo.isClass"] == "object"
    assert model.do("/cube", "getPropertyName", 0, {"prefix": "mass"}) == ("mass", "shape")


def test_an_enumeration_is_set_by_name_and_number_and_read_as_text(model: Model) -> None:
    hinge = model.at("/robot/hinge")
    assert model.get(hinge, "joint.type") == "revolute"
    model.set(hinge, "dynamics.ctrlMode", "velocity")
    assert model.get(hinge, "dynamics.ctrlMode") == 4
    model.set(hinge, "dynamics.ctrlMode", 8)
    assert model.do(hinge, "getStringProperty", "dynamics.ctrlMode") == ("position",)
    assert model.do(hinge, "getEnumProperty", "dynamics.ctrlMode") == (8,)
    with pytest.raises(CommandError, match="is not in the enumeration jointDynamicsCtrlMode; it has free 0"):
        model.set(hinge, "dynamics.ctrlMode", "warp")
    for number, word in ((0, "stopped"), (17, "running")):
        assert model.get("scene", "simulation.state") == number
        assert model.do("scene", "getStringProperty", "simulation.state") == (word,)
        model.run()


def test_a_colour_has_four_bytes_and_is_taken_in_every_form(model: Model) -> None:
    for given in (Color(b"\xff\x80\x00\xff"), b"\xff\x80\x00\xff", [1.0, 128 / 255, 0.0], [255, 128, 0, 255]):
        model.set("/cube", "color.diffuse", [0.0, 0.0, 0.0])
        model.set("/cube", "applyColor.diffuse", given)
        assert model.get("/cube", "color.diffuse") == Color(b"\xff\x80\x00\xff")
    with pytest.raises(CommandError, match="must be a colour"):
        model.set("/cube", "color.diffuse", "red")


def test_points_are_columns_and_an_inertia_is_three_by_three(model: Model) -> None:
    vertices = model.get("/cube", "vertices")
    assert vertices.rows == 3
    assert {abs(each) for each in vertices.numbers} == {0.1}
    inertia = model.get("/cube", "inertiaMatrix")
    assert (inertia.rows, inertia.columns) == (3, 3)
    model.set("/cube", "inertiaMatrix", Matrix(3, 3, [0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.25]))
    assert model.get("/cube", "pmi").numbers == pytest.approx([0.1, 0.2, 0.25])


VALUES: list[tuple[Any, int]] = [
    (True, 0),
    (7, 1),
    (0.5, 2),
    ("text", 3),
    (b"\x00\xff", 4),
    (Matrix(3, 1, [1.0, 2.0, 3.0]), 5),
    (Quaternion([0.0, 0.0, 0.0, 1.0]), 6),
    (Pose([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0]), 7),
    (Matrix(2, 2, [1.0, 2.0, 3.0, 4.0]), 18),
    (Color(b"\x00\xff\x00\xff"), 26),
    (Ref(-12), 21),
    ([Ref(-12), Ref(-13)], 22),
    ([1, "two"], 12),
]


@pytest.mark.parametrize(("value", "kind"), VALUES)
@pytest.mark.parametrize("group", ["customData", "signal"])
@pytest.mark.parametrize("target", ["/cube", "scene", "app"])
def test_properties_of_a_program_have_the_type_of_their_value(
    model: Model, target: str, group: str, value: Any, kind: int
) -> None:
    name = f"{group}.mine"
    model.set(target, name, value)
    assert model.get(target, name) == value
    assert model.do(target, "getPropertyInfo", name)[:2] == (kind, 4)
    model.do(target, "removeProperty", name)
    assert model.do(target, "getPropertyInfo", name, {"noError": True}) == (None, None, None)


def test_values_within_a_map_are_those_of_api_1(model: Model) -> None:
    model.set(
        "/cube", "customData.map", {"m": Matrix(2, 2, [1.0, 2.0, 3.0, 4.0]), "c": [Color(b"\xff\0\0\xff")]}
    )
    assert model.get("/cube", "customData.map") == {"m": [[1.0, 2.0], [3.0, 4.0]], "c": [[1.0, 0.0, 0.0]]}


def test_references_follow_objects(model: Model) -> None:
    model.set("/cube", "refs.friends", [model.at("/wall")])
    assert model.get("/cube", "refs.friends") == [model.at("/wall")]


def test_settings_of_windows_are_kept(model: Model) -> None:
    for name, value in (
        ("length", 0.3),
        ("hierarchyColor", 2),
        ("mov.translInSim", False),
        ("color.diffuse", Color(b"\1\2\3\xff")),
    ):
        model.set("/robot/hinge", name, value)
        assert model.get("/robot/hinge", name) == value
    assert model.get("/robot/hinge", "mov.optionsFlags") == 2


def test_what_the_server_lacks_has_a_reason(model: Model) -> None:
    with pytest.raises(CommandError, match="no licence that is tied to a machine"):
        model.get("app", "machineId")
    with pytest.raises(CommandError, match="stays false: motion profiles"):
        model.set("/robot/hinge", "dynamics.smoothMotionProfile", True)
    with pytest.raises(CommandError, match="can only be read"):
        model.set("/robot/hinge", "joint.type", "prismatic")


def test_all_properties_are_read_at_once(model: Model) -> None:
    for target in ("/cube", "/robot/hinge", "/robot/mark", "/ray", "/robot/hinge/arm/eye", "scene", "app"):
        found = model.do(target, "getProperties", {"skipLarge": True})
        infos = model.do(target, "getPropertiesInfos")
        assert len(found) > 30
        assert set(found) <= set(infos)


def test_a_removed_object_is_not_valid(model: Model) -> None:
    cube = model.at("/cube")
    assert model.do(cube, "isValid")
    model.do(cube, "remove")
    assert not model.do(cube, "isValid")
    with pytest.raises(CommandError, match="target does not exist"):
        model.get(cube, "position")


def test_the_options_of_the_engine_are_one_text(model: Model) -> None:
    options = json.loads(model.get("/cube", "dynamics.engineProperties"))["mujoco"]
    assert options["condim"] == model.get("/cube", "dynamics.mujoco.condim")
    changed = json.dumps({"mujoco": {"friction": [0.3, 0.01, 0.001], "priority": 2}})
    model.set("/cube", "dynamics.engineProperties", changed)
    assert model.get("/cube", "dynamics.mujoco.friction") == [0.3, 0.01, 0.001]
    assert model.get("/cube", "dynamics.mujoco.priority") == 2
    model.set("scene", "dynamics.engineProperties", '{"mujoco": {"density": 1.2}}')
    assert model.get("scene", "dynamics.mujoco.density") == 1.2
    for text, problem in (
        ("density", "JSON"),
        ('{"bullet": {}}', "only engine"),
        ('{"mujoco": {"spin": 1}}', "no option"),
        ('{"mujoco": {"condim": "x"}}', "must be"),
    ):
        with pytest.raises(CommandError, match=problem):
            model.set("/cube", "dynamics.engineProperties", text)


def test_a_shape_without_texture_has_no_coordinates(model: Model) -> None:
    assert model.get("/cube", "texture.coordinates") == []
    assert model.get("/cube", "texture.applyMode") == 0
