# pyright: reportPrivateUsage=false
"""Entities of simulation_interfaces: features, lists, states, infos, bounds, named poses, spawning, deleting."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from ros2_world import SCENE, Peer, Ros2World, ros2_world

from simx_server.gateways.ros2.standard import filters, patterns
from simx_server.gateways.ros2.standard.standard import Standard
from simx_server.gateways.ros2.table_call import Call
from simx_server.ros2_messages import BY_NAME, SERVICES

UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)
BOX = '<mujoco><worldbody><body name="crate"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody></mujoco>'
ROBOT = """<robot name="two"><link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0"
ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2World]:
    scene = SCENE.replace('<site name="tip"', '<site name="tip"', 1).replace(
        "<worldbody>", '<worldbody><site name="goal" pos="1 2 3" quat="0 0 0 1"/>'
    )
    with ros2_world(tmp_path_factory.mktemp("entities"), scene=scene) as opened:
        yield opened


@pytest.fixture
def peer(server: Ros2World) -> Iterator[Peer]:
    peer = server.peer()
    yield peer
    peer.trigger("stop")
    peer.call_standard("ResetSimulation", "reset_simulation", scope=255)


def ask(peer: Peer, kind: str, code: int = OK, /, **request: Any) -> dict[str, Any]:
    """Call a service whose name follows from its type; check the code, and that each refusal says why."""
    name = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in kind).lstrip("_")
    answer = peer.call_standard(kind, name, **request)
    assert answer["result"]["result"] == code, answer["result"]
    assert bool(answer["result"]["error_message"]) == (code != OK)
    return answer


def pose(x: float, y: float, z: float, frame: str = "") -> dict[str, Any]:
    return {
        "header": {"frame_id": frame},
        "pose": {"position": {"x": x, "y": y, "z": z}, "orientation": {"w": 1.0}},
    }


def spawn(peer: Peer, code: int = OK, /, text: str = BOX, **request: Any) -> dict[str, Any]:
    given = {"uri": "", "resource_string": text} | request.pop("resource", {})
    request = {"initial_pose": pose(0, 0, 2), "name": "crate1", **request}
    return ask(peer, "SpawnEntity", code, entity_resource=given, **request)


def names(peer: Peer, **filters: Any) -> list[str]:
    return ask(peer, "GetEntities", filters=filters)["entities"]


def place(peer: Peer, name: str) -> dict[str, float]:
    return ask(peer, "GetEntityState", entity=name)["state"]["pose"]["position"]


def test_features_name_every_service_that_the_node_has(server: Ros2World, peer: Peer) -> None:
    answer = peer.call_standard("GetSimulatorFeatures", "get_simulator_features")["features"]
    known = BY_NAME["simulation_interfaces/msg/SimulatorFeatures"].constants
    found = {name for name, number in known.items() if number in answer["features"]}
    assert known.keys() - found == {
        "ENTITY_BOUNDS_CONVEX",
        "SIMULATION_RESET_TIME",
        "SIMULATION_RESET_STATE",
    }
    assert {"mjcf", "urdf", "ttm"} <= set(answer["spawn_formats"])
    peer.watch()
    for name in SERVICES:
        if name.startswith("simulation_interfaces/srv/"):
            short = name.rpartition("/")[2]
            peer.wait_for_token(
                lambda token, short=short: f"/simulation_interfaces::srv::dds_::{short}_/" in token
            )
    counts = [token for token in peer.tokens if "::srv::dds_::SpawnEntity_" in token]
    assert len(counts) == 1


def test_entities_are_models_and_the_objects_at_the_top(peer: Peer) -> None:
    assert names(peer) == ["floor", "shoulder", "box", "stand"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("^b", ["box"]),
        ("(der|box)$", ["shoulder", "box"]),
        ("^[[:alpha:]]{5}$", ["floor", "stand"]),
        ("o.$", ["floor", "box"]),
        ("nothing", []),
    ],
)
def test_a_filter_is_a_posix_pattern(peer: Peer, text: str, expected: list[str]) -> None:
    assert names(peer, filter=text) == expected


@pytest.mark.parametrize(
    "text", ["(", "a{3,1}", "[z-a]", "*a", "a{999}", "[[:vowel:]]", "x" * 2000, "(" * 100, "\\"]
)
def test_a_filter_that_is_no_pattern_is_refused(peer: Peer, text: str) -> None:
    ask(peer, "GetEntities", FAILED, filters={"filter": text})


def test_a_filter_that_would_take_too_long_is_refused(peer: Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    assert names(peer, filter="(a*)*(a*)*b$") == []
    monkeypatch.setattr(filters, "MOST_COST", 100)
    ask(peer, "GetEntities", FAILED, filters={"filter": "(a*)*b"})


def test_a_long_bracket_looks_at_each_character_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    monkeypatch.setitem(patterns._CLASSES, "alpha", lambda one: bool(asked.append(one)))
    assert not patterns.Pattern("[[:alpha:]]{0,200}X").is_in("ab" * 20)
    assert sorted(asked) == ["a", "b"]


def test_categories_are_guessed_until_a_node_sets_them(peer: Peer) -> None:
    def info(name: str) -> dict[str, Any]:
        return ask(peer, "GetEntityInfo", entity=name)["info"]

    assert [info(name)["category"]["category"] for name in ("shoulder", "stand", "box")] == [1, 5, 0]
    given = {"category": {"category": 2}, "description": "walks", "tags": ["a", "b"]}
    ask(peer, "SetEntityInfo", entity="box", info=given)
    assert info("box") == given
    assert names(peer, categories=[{"category": 2}, {"category": 5}]) == ["floor", "box", "stand"]
    assert names(peer, tags={"tags": ["b", "c"], "filter_mode": 0}) == ["box"]
    assert names(peer, tags={"tags": ["b", "c"], "filter_mode": 1}) == []
    ask(peer, "SetEntityInfo", FAILED, entity="box", info={**given, "category": {"category": 3}})
    ask(peer, "SetEntityInfo", FAILED, entity="box", info={**given, "tags": ["t"] * 1000})
    ask(peer, "GetEntities", FAILED, filters={"tags": {"tags": ["b"], "filter_mode": 7}})
    assert info("box") == given


def test_bounds_are_a_box_in_the_frame_of_the_entity(peer: Peer) -> None:
    bounds = ask(peer, "GetEntityBounds", entity="box")["bounds"]
    assert bounds["type"] == 1
    upper, lower = ([*point.values()] for point in bounds["points"])
    assert upper == pytest.approx([0.1] * 3, abs=1e-6)
    assert lower == pytest.approx([-0.1] * 3, abs=1e-6)


def corner(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


@pytest.mark.parametrize(
    ("kind", "points", "is_in"),
    [
        (3, [corner(1, 0, 1), corner(0.41, 0, 0)], True),
        (3, [corner(1, 0, 1), corner(0.39, 0, 0)], False),
        (3, [corner(1.2, 0.2, 0.5), corner(0.13, 0, 0)], False),
        (3, [corner(1.2, 0.2, 0.5), corner(0.15, 0, 0)], True),
        (1, [corner(2, 1, 1), corner(1.05, -1, 0.3)], True),
        (1, [corner(2, 1, 1), corner(1.11, -1, 0.3)], False),
    ],
)
def test_bounds_select_what_they_meet(peer: Peer, kind: int, points: list[Any], is_in: bool) -> None:
    found = names(peer, filter="box", bounds={"type": kind, "points": points})
    assert found == (["box"] if is_in else [])


@pytest.mark.parametrize(
    ("kind", "points", "code"),
    [(2, [corner(0, 0, 0)] * 4, UNSUPPORTED), (9, [], UNSUPPORTED), (1, [], FAILED),
     (3, [corner(0, float("nan"), 0)] * 2, FAILED)],
)  # fmt: skip
def test_other_bounds_are_refused(peer: Peer, kind: int, points: list[Any], code: int) -> None:
    ask(peer, "GetEntities", code, filters={"bounds": {"type": kind, "points": points}})


def test_states_have_pose_velocity_and_acceleration_of_a_falling_box(server: Ros2World, peer: Peer) -> None:
    peer.trigger("start")
    peer.trigger("pause")
    peer.call_standard("ResetSimulation", "reset_simulation", scope=255)
    ask(peer, "SetEntityState", entity="box", state=pose(1, 0, 50), set_pose=True)
    ask(peer, "StepSimulation", steps=2)
    state = ask(peer, "GetEntityState", entity="box")["state"]
    assert state["header"]["frame_id"] == "world"
    assert state["header"]["stamp"] == {"sec": 0, "nanosec": 100_000_000}
    assert state["acceleration"]["linear"]["z"] == pytest.approx(-9.81, abs=1e-6)
    assert state["twist"]["linear"]["z"] == pytest.approx(-0.075 * 9.81, rel=0.1)
    states = ask(peer, "GetEntitiesStates", filters={"filter": "box|stand"})
    assert states["entities"] == ["box", "stand"]
    assert states["states"][0]["pose"] == state["pose"]
    assert states["states"][1]["acceleration"]["linear"] == {"x": 0.0, "y": 0.0, "z": 0.0}


def test_an_entity_gets_pose_and_velocity_by_frames_of_others(server: Ros2World, peer: Peer) -> None:
    ask(peer, "SetEntityState", entity="box", state=pose(0.5, 0, 10, "stand"), set_pose=True)
    found = place(peer, "box")
    assert (found["x"], found["y"], found["z"]) == pytest.approx((2, 0.5, 10.5), abs=1e-4)
    peer.trigger("start")
    peer.trigger("pause")
    twist = {"linear": {"x": 2.0}, "angular": {"z": 3.0}}
    # High above the floor, to which it may have fallen before the pause.
    given = {**pose(0.5, 0, 10, "stand"), "twist": twist}
    ask(peer, "SetEntityState", entity="box", state=given, set_pose=True, set_twist=True)
    ask(peer, "StepSimulation", steps=1)
    state = ask(peer, "GetEntityState", entity="box")["state"]
    assert state["twist"]["linear"]["y"] == pytest.approx(2, abs=1e-4)
    assert state["twist"]["angular"]["z"] == pytest.approx(3, abs=1e-3)
    ask(peer, "SetEntityState", entity="box", state=pose(0, 0, 20), set_pose=True)
    ask(peer, "StepSimulation", steps=1)
    # The velocity is kept while only the pose is set.
    assert place(peer, "box")["y"] == pytest.approx(0.1, abs=1e-4)


@pytest.mark.parametrize(
    ("state", "code"),
    [
        (pose(0, 0, float("nan")), 101),
        (pose(0, 0, 1e9), 101),
        (pose(0, 0, 1, "nowhere"), 101),
        ({"pose": {"orientation": {"w": 0.0}}}, 101),
        ({"pose": {"orientation": {"w": 1.0}}, "twist": {"linear": {"x": float("inf")}}}, FAILED),
    ],
)
def test_a_state_that_is_not_valid_changes_nothing(peer: Peer, state: dict[str, Any], code: int) -> None:
    before = place(peer, "box")
    ask(peer, "SetEntityState", code, entity="box", state=state, set_pose=True, set_twist=True)
    assert place(peer, "box") == before


def test_a_static_entity_gets_no_velocity_and_none_gets_an_acceleration(peer: Peer) -> None:
    moving = {**pose(0, 0, 0), "twist": {"linear": {"x": 1.0}}, "acceleration": {"linear": {"x": 1.0}}}
    ask(peer, "SetEntityState", FAILED, entity="stand", state=moving, set_twist=True)
    ask(peer, "SetEntityState", FAILED, entity="box", state=moving, set_acceleration=True)
    ask(peer, "SetEntityState", entity="stand", state=pose(2, 1, 0.5), set_pose=True, set_twist=True)
    assert place(peer, "stand")["y"] == pytest.approx(1)
    ask(peer, "SetEntityState", entity="stand", state=pose(2, 0, 0.5), set_pose=True)


@pytest.mark.parametrize(
    "kind", ["GetEntityState", "GetEntityInfo", "GetEntityBounds", "DeleteEntity", "SetEntityState"]
)
def test_an_unknown_entity_is_not_found_and_the_nearest_is_named(peer: Peer, kind: str) -> None:
    assert "did you mean" in ask(peer, kind, NOT_FOUND, entity="boxx")["result"]["error_message"]


def test_dummies_at_the_top_are_named_poses(peer: Peer) -> None:
    (found,) = ask(peer, "GetNamedPoses")["poses"]
    assert found["name"] == "goal"
    assert [*found["pose"]["position"].values()] == pytest.approx([1, 2, 3])
    assert abs(found["pose"]["orientation"]["z"]) == pytest.approx(1)
    assert ask(peer, "GetNamedPoses", tags={"tags": ["parking"]})["poses"] == []
    assert ask(peer, "GetNamedPoseBounds", name="goal")["bounds"]["type"] == 0
    ask(peer, "GetNamedPoseBounds", NOT_FOUND, name="box")


# --- spawning ------------------------------------------------------------------------------------


def test_a_text_in_mjcf_or_urdf_is_spawned_at_its_pose(peer: Peer) -> None:
    assert spawn(peer, initial_pose=pose(0, 0, 1, "stand"))["entity_name"] == "crate1"
    assert [*place(peer, "crate1").values()] == pytest.approx([2, 0, 1.5], abs=1e-6)
    assert spawn(peer, text=ROBOT, name="two")["entity_name"] == "two"
    assert names(peer, filter="crate|two") == ["crate1", "two"]
    ask(peer, "DeleteEntity", entity="crate1")
    assert names(peer, filter="crate|two") == ["two"]


def test_a_shipped_model_is_spawned_by_its_name_and_again_with_another(peer: Peer) -> None:
    spawnables = ask(peer, "GetSpawnables")["spawnables"]
    assert {"uri": "rg2", "resource_string": ""} in [each["entity_resource"] for each in spawnables]
    first = spawn(peer, name="", resource={"uri": "rg2"})["entity_name"]
    assert first in names(peer)
    spawn(peer, 101, name="", resource={"uri": "rg2"})
    second = spawn(peer, name=first, allow_renaming=True, resource={"uri": "rg2"})["entity_name"]
    assert second == f"{first}_0"
    assert {first, second} <= set(names(peer))


@pytest.mark.parametrize(
    ("code", "request_"),
    [
        (101, {"name": "box"}),
        (102, {"name": "a/b"}),
        (102, {"name": "x" * 200}),
        (103, {"resource": {"uri": "robot.usd"}}),
        (103, {"text": "<sdf version='1.6'/>"}),
        (103, {"text": "a robot"}),
        (104, {"text": ""}),
        (105, {"entity_namespace": "/1 2"}),
        (105, {"entity_namespace": "/a" * 100}),
        (106, {"text": "<mujoco><worldbody><body></mujoco>"}),
        (106, {"text": "<robot name='r'><link/></robot>"}),
        (
            107,
            {"text": BOX.replace("<worldbody>", '<asset><mesh name="m" file="no.stl"/></asset><worldbody>')},
        ),
        (109, {"initial_pose": pose(0, 0, 1, "nowhere")}),
        (109, {"initial_pose": pose(float("inf"), 0, 1)}),
        (NOT_FOUND, {"resource": {"uri": "file:///no_such_model.xml"}}),
        (NOT_FOUND, {"resource": {"uri": "https://example.org/a.urdf"}}),
        (NOT_FOUND, {"resource": {"uri": "http://[bad"}}),
    ],
)
def test_each_reason_against_spawning_has_its_code(peer: Peer, code: int, request_: dict[str, Any]) -> None:
    before = names(peer)
    spawn(peer, code, **request_)
    assert names(peer) == before


def test_several_are_spawned_and_each_has_its_result(peer: Peer) -> None:
    def one(name: str, text: str = BOX) -> dict[str, Any]:
        resource = {"resource_string": text}
        return {"name": name, "entity_resource": resource, "initial_pose": pose(0, 0, 3)}

    answer = ask(peer, "SpawnEntities", spawn_requests=[one("c1"), one("c2")])
    assert [each["entity_name"] for each in answer["results"]] == ["c1", "c2"]
    answer = ask(peer, "SpawnEntities", 150, spawn_requests=[one("c3"), one("c4", ""), one("c1")])
    assert [each["result"]["result"] for each in answer["results"]] == [OK, 104, 101]
    assert {"c1", "c2", "c3"} <= set(names(peer))
    ask(peer, "SpawnEntities", FAILED, spawn_requests=[one("c")] * 101)


def test_earlier_releases_spawn_load_and_place_with_their_own_types(server: Ros2World, peer: Peer) -> None:
    def call(kind: str, name: str, /, **request: Any) -> dict[str, Any]:
        return peer.call(f"simulation_interfaces/srv/{kind}", name, request, is_older=True)

    request = {"name": "old", "resource_string": BOX, "initial_pose": pose(0, 0, 4)}
    assert call("SpawnEntity", "spawn_entity", **request)["entity_name"] == "old"
    assert (
        call("SetEntityState", "set_entity_state", entity="old", state=pose(0, 3, 4))["result"]["result"]
        == OK
    )
    assert place(peer, "old")["y"] == pytest.approx(3)
    assert "rg2" in [each["uri"] for each in call("GetSpawnables", "get_spawnables")["spawnables"]]


def test_a_namespace_stands_before_the_topics_of_what_is_spawned(server: Ros2World, peer: Peer) -> None:
    peer.watch()
    name = spawn(peer, name="", resource={"uri": "pioneer_p3dx"}, entity_namespace="/fleet/one")[
        "entity_name"
    ]
    peer.wait_for_token(lambda token: "/%fleet%one%cmd_vel/" in token)
    peer.wait_for_token(lambda token: "/%fleet%one%odom/" in token)
    ask(peer, "DeleteEntity", entity=name)
    peer.wait_for_no_token(lambda token: "fleet" in token)


# --- the reset by parts --------------------------------------------------------------------------


def test_a_reset_of_everything_deletes_what_was_spawned(server: Ros2World, peer: Peer) -> None:
    spawn(peer, name="before")
    peer.trigger("start")
    spawn(peer, name="within")
    ask(peer, "ResetSimulation", scope=255)
    assert "before" not in names(peer)
    assert "within" not in names(peer)
    assert peer.call_standard("GetSimulationState", "get_simulation_state")["state"]["state"] == 1
    peer.trigger("stop")
    assert names(peer, filter="before|within") == []


def test_a_reset_of_time_and_state_keeps_what_was_spawned(server: Ros2World, peer: Peer) -> None:
    spawn(peer, name="before", initial_pose=pose(3, 0, 5))
    peer.trigger("start")
    peer.trigger("pause")
    spawn(peer, name="within", initial_pose=pose(4, 0, 5))
    ask(peer, "StepSimulation", steps=5)
    assert place(peer, "within")["z"] < 4.9
    ask(peer, "ResetSimulation", scope=3)
    assert names(peer, filter="before|within") == ["before", "within"]
    assert server.simulation.step_count == 0
    assert place(peer, "before")["z"] == pytest.approx(5)
    assert place(peer, "within")["z"] == pytest.approx(5)
    ask(peer, "ResetSimulation", scope=4)
    assert names(peer, filter="before|within") == []
    peer.trigger("stop")
    assert names(peer, filter="before|within") == []


def test_a_reset_names_what_it_could_not_spawn_again(server: Ros2World, peer: Peer) -> None:
    file = server.simulation.files.workspace / "fleeting.xml"
    file.write_text(BOX)
    peer.trigger("start")
    peer.trigger("pause")
    spawn(peer, name="within", resource={"uri": "fleeting.xml", "resource_string": ""})
    file.unlink()
    answer = ask(peer, "ResetSimulation", FAILED, scope=3)
    assert "'within' was not spawned again" in answer["result"]["error_message"]
    assert peer.call_standard("GetSimulationState", "get_simulation_state")["state"]["state"] == 2


def test_what_was_spawned_is_forgotten_when_it_has_gone(server: Ros2World, peer: Peer) -> None:
    (standard,) = [each for each in server.gateway._contents if isinstance(each, Standard)]
    known = standard._spawning._spawned
    peer.trigger("start")
    spawn(peer, name="within", entity_namespace="/fleet")
    assert [order.name for order in known.values()] == ["within"]
    (handle,) = known
    peer.trigger("stop")
    assert not known
    assert not server.gateway._robots.namespace(handle)
    spawn(peer, name="first")
    server.on_server(lambda: server.gateway._client.ask(Call("simxRemoveModel", [*known])))
    spawn(peer, name="second")
    assert [order.name for order in known.values()] == ["second"]
