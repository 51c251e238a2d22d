"""Worlds of simulation_interfaces: loading, unloading, listing; and the action that makes simulation steps."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from action_client import ABORTED, CANCELED, SUCCEEDED, ActionClient
from processes import ROOT
from ros2_world import SCENE, Peer, Ros2World, attachment, ros2_world

from simx_server.gateways.ros2.actions import Goal
from simx_server.ros2_messages import SERVICES
from simx_server.simulation.simulation import SimulationState

UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)
STEPS = "simulation_interfaces/action/SimulateSteps"
SAMPLE = next((ROOT.parent / "shared" / "ttt-samples").rglob("test.ttt"), Path())
"""A scene that the import leaves something out of."""


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2World]:
    with ros2_world(tmp_path_factory.mktemp("worlds")) as opened:
        yield opened


def ask(peer: Peer, kind: str, code: int = OK, /, **request: Any) -> dict[str, Any]:
    name = "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in kind).lstrip("_")
    answer = peer.call_standard(kind, name, **request)
    assert answer["result"]["result"] == code, answer["result"]
    return answer


def load(peer: Peer, code: int = OK, /, uri: str = "", text: str = "", **more: Any) -> dict[str, Any]:
    resource = {"uri": uri, "resource_string": text}
    return ask(peer, "LoadWorld", code, world_resource=resource, **more)["world"]


def state(peer: Peer) -> int:
    return ask(peer, "GetSimulationState")["state"]["state"]


def test_a_world_of_the_list_is_loaded_and_stops_the_run(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    worlds = ask(peer, "GetAvailableWorlds")["worlds"]
    (wanted,) = [each for each in worlds if each["name"] == "cart_pole"]
    assert wanted["tags"] == ["shipped"]
    loaded = load(peer, uri=wanted["world_resource"]["uri"])
    assert loaded["name"] == "cart_pole"
    assert state(peer) == 0
    assert ask(peer, "GetCurrentWorld")["world"] == loaded
    assert loaded["world_resource"]["uri"] == "cart_pole"
    assert "floor" not in ask(peer, "GetEntities", filters={"filter": "^stand$"})["entities"]


def test_worlds_are_selected_by_tags_and_unknown_sources_are_named(server: Ros2World) -> None:
    peer = server.peer()
    worlds = ask(peer, "GetAvailableWorlds", filter={"tags": ["workspace"]})["worlds"]
    assert all("workspace" in each["tags"] for each in worlds)
    refused = ask(peer, "GetAvailableWorlds", UNSUPPORTED, additional_sources=["../elsewhere"])
    assert "../elsewhere" in refused["result"]["error_message"]
    found = ask(peer, "GetAvailableWorlds", additional_sources=["/etc"], continue_on_error=True)["worlds"]
    assert "cart_pole" in [each["name"] for each in found]


@pytest.mark.parametrize(
    ("kind", "request_", "why"),
    [
        ("GetAvailableWorlds", {"filter": {"tags": ["a"], "filter_mode": 9}}, "there is no filter_mode 9"),
        ("GetAvailableWorlds", {"filter": {"tags": ["a"] * 101}}, "at most 100 tags, not 101"),
        ("GetEntities", {"filters": {"tags": {"tags": ["a"] * 101}}}, "at most 100 tags, not 101"),
        ("GetAvailableWorlds", {"additional_sources": ["a"] * 101}, "at most 100 sources, not 101"),
        ("GetSpawnables", {"sources": ["a"] * 101}, "at most 100 sources, not 101"),
    ],
)
def test_a_list_that_is_not_valid_or_too_long_is_refused_with_the_reason(
    server: Ros2World, kind: str, request_: dict[str, Any], why: str
) -> None:
    answer = ask(server.peer(), kind, FAILED, **request_)
    assert why in answer["result"]["error_message"]


def test_a_text_is_loaded_and_other_types_of_earlier_releases_too(server: Ros2World) -> None:
    peer = server.peer()
    load(peer, text=SCENE)
    assert "box" in ask(peer, "GetEntities")["entities"]
    kind = "simulation_interfaces/srv/LoadWorld"
    answer = peer.call(kind, "load_world", {"uri": "cart_pole"}, is_older=True)
    assert answer["world"]["name"] == "cart_pole"


@pytest.mark.parametrize(
    ("code", "request_"),
    [
        (101, {"uri": "world.sdf"}),
        (101, {"text": "<sdf/>"}),
        (102, {}),
        (103, {"text": "<mujoco><worldbody></mujoco>"}),
        (
            104,
            {"text": SCENE.replace("<worldbody>", '<asset><mesh name="m" file="n.stl"/></asset><worldbody>')},
        ),
        (NOT_FOUND, {"uri": "no_such_world"}),
        (NOT_FOUND, {"uri": "ftp://host/world.xml"}),
    ],
)
def test_each_reason_against_a_world_has_its_code_and_the_scene_stays(
    server: Ros2World, code: int, request_: dict[str, str]
) -> None:
    peer = server.peer()
    before = server.simulation.scene
    assert load(peer, code, **request_)["name"] == ""
    assert server.simulation.scene is before


def test_an_unloaded_world_leaves_none_until_the_next_is_loaded(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    ask(peer, "UnloadWorld")
    assert state(peer) == 4
    ask(peer, "UnloadWorld", 101)
    ask(peer, "GetCurrentWorld", 101)
    refused = ask(peer, "SetSimulationState", 102, state={"state": 1})
    assert "load one first" in refused["result"]["error_message"]
    load(peer, text=SCENE)
    assert state(peer) == 0
    assert ask(peer, "GetCurrentWorld")["result"]["result"] == OK


@pytest.mark.skipif(not SAMPLE.is_file(), reason="V-REP's sample files are not here")
def test_a_world_of_v_rep_with_elements_that_are_left_out_is_refused_if_wanted(
    server: Ros2World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    peer = server.peer()
    monkeypatch.setattr(server.simulation.files, "workspace", tmp_path)
    (tmp_path / SAMPLE.name).write_bytes(SAMPLE.read_bytes())
    load(peer, uri=SAMPLE.name)
    load(peer, 106, uri=SAMPLE.name, fail_on_unsupported_element=True)
    assert state(peer) == 4
    load(peer, text=SCENE)


# --- the action ----------------------------------------------------------------------------------


@pytest.fixture
def steps(server: Ros2World) -> ActionClient:
    load(server.peer(), text=SCENE)
    return ActionClient(server.peer(), "simulate_steps", STEPS)


def pause(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")


def test_the_action_makes_steps_with_feedback_after_each(server: Ros2World, steps: ActionClient) -> None:
    pause(server)
    before = server.simulation.step_count
    server.wait_until(lambda: True)
    assert steps.send(1, steps=3)
    answer = steps.result(1)
    assert (answer["status"], answer["result"]["result"]["result"]) == (SUCCEEDED, OK)
    assert server.simulation.step_count == before + 3
    assert server.simulation.state is SimulationState.PAUSED
    seen = [steps.next_feedback() for _ in range(3)]
    assert seen == [{"completed_steps": n, "remaining_steps": 3 - n} for n in (1, 2, 3)]
    steps.next_status(1, SUCCEEDED)


def test_an_action_without_paused_simulation_is_aborted_with_the_reason(steps: ActionClient) -> None:
    assert steps.send(2, steps=3)
    answer = steps.result(2)
    assert (answer["status"], answer["result"]["result"]["result"]) == (ABORTED, FAILED)
    assert "start and pause it first" in answer["result"]["result"]["error_message"]


def test_a_goal_is_canceled_after_the_step_that_is_made(server: Ros2World, steps: ActionClient) -> None:
    pause(server)
    assert steps.send(3, steps=1_000_000)
    asking: list[Any] = []
    thread = threading.Thread(target=lambda: asking.append(steps.result(3)))
    thread.start()
    steps.next_feedback()
    canceled = steps.cancel(3)
    assert canceled["return_code"] == 0
    assert [int(each["goal_id"]["uuid"][0]) for each in canceled["goals_canceling"]] == [3]
    thread.join(30)
    assert asking[0]["status"] == CANCELED
    server.wait_until(lambda: server.simulation.state is SimulationState.PAUSED)
    assert steps.cancel(3)["return_code"] == 3
    assert steps.cancel(99)["return_code"] == 2
    assert steps.cancel(0)["return_code"] == 0


def test_all_goals_are_canceled_together(server: Ros2World, steps: ActionClient) -> None:
    pause(server)
    assert steps.send(11, steps=1_000_000)
    assert steps.send(12, steps=1_000_000)
    assert len(steps.cancel(0)["goals_canceling"]) == 2
    assert [steps.result(n)["status"] for n in (11, 12)] == [CANCELED] * 2


def test_hostile_goals_are_rejected(
    server: Ros2World, steps: ActionClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    pause(server)
    assert steps.send(21, steps=1)
    assert not steps.send(21, steps=1)
    assert not steps.send(0, steps=1)
    assert steps.result(22)["status"] == 0
    assert steps.send(23, steps=0)
    assert steps.result(23)["status"] == ABORTED
    monkeypatch.setattr("simx_server.gateways.ros2.actions.MOST_ACTIVE", 2)
    assert steps.send(24, steps=1_000_000)
    assert steps.send(25, steps=1_000_000)
    assert not steps.send(26, steps=1)
    kind = SERVICES[f"{STEPS}_SendGoal"]
    key = f"0/simulate_steps/_action/send_goal/{kind.dds_name}/{kind.hash}"
    ((payload, _),) = steps.peer.ask(key, b"\0\1\0\0" + bytes(5), attachment())
    assert not kind.response.decode(payload)["accepted"]
    monkeypatch.setattr("simx_server.gateways.ros2.actions.MOST_KEPT", 1)
    steps.cancel(0)
    assert steps.result(21)["status"] == 0


def test_a_goal_that_has_ended_keeps_its_result_and_not_its_request() -> None:
    goal = Goal(bytes(range(16)), {"trajectory": {"points": [{}] * 1000}}, {"sec": 0, "nanosec": 0})
    goal.end(SUCCEEDED, {"error_code": 0})
    assert not goal.request
    assert goal.answer() == {"status": SUCCEEDED, "result": {"error_code": 0}}
