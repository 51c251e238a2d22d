"""Services that control the run: the node's own, and those of simulation_interfaces."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import zenoh
from ros2_world import CLOCK, TRIGGER, Peer, Ros2World, attachment, ros2_world, seconds

from simx_server.gateways.ros2.content.control import Control
from simx_server.gateways.ros2.desk import Desk
from simx_server.service.answers.link import Link
from simx_server.service.clients.sessions import ClientSession
from simx_server.simulation.simulation import SimulationState

STOPPED, PLAYING, PAUSED = 0, 1, 2
OK, UNSUPPORTED, INCORRECT_STATE, FAILED = 1, 0, 3, 4


def state(server: Ros2World) -> SimulationState:
    return server.on_server(lambda: server.simulation.state)


def test_an_answer_has_the_bytes_the_number_and_the_sender_that_rmw_expects(server: Ros2World) -> None:
    sent = bytes.fromhex("c900000000000000 003f9218a863ea18 10 1e4246dd97154e358eb5ba7ab77184a3")
    ((payload, data),) = server.peer().ask(f"0/simx/start/{TRIGGER}", bytes.fromhex("0001000000"), sent)
    assert payload[:5] == bytes.fromhex("0001000001")
    assert len(data) == 33
    assert data[:8] + data[16:] == sent[:8] + sent[16:]
    assert data[8:16] > bytes(8)
    assert state(server) is SimulationState.RUNNING


def test_start_pause_continue_and_stop(server: Ros2World) -> None:
    peer = server.peer()
    for verb, expected in [
        ("start", SimulationState.RUNNING),
        ("pause", SimulationState.PAUSED),
        ("start", SimulationState.RUNNING),
        ("stop", SimulationState.STOPPED),
    ]:
        assert peer.trigger(verb)["success"], verb
        assert state(server) is expected


def test_what_is_so_already_succeeds_and_what_cannot_be_says_why(server: Ros2World) -> None:
    peer = server.peer()
    assert peer.trigger("stop") == {"success": True, "message": "the simulation is stopped already"}
    refused = peer.trigger("pause")
    assert not refused["success"]
    assert "start it first" in refused["message"]
    refused = peer.trigger("step")
    assert not refused["success"]
    assert "start and pause it first" in refused["message"]
    peer.trigger("start")
    assert peer.trigger("start") == {"success": True, "message": "the simulation runs already"}
    assert "pause it first" in peer.trigger("step")["message"]


def test_a_step_is_one_simulation_step_after_which_it_is_paused_again(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")
    before = server.simulation.step_count
    for count in (1, 2, 3):
        assert peer.trigger("step") == {"success": True, "message": "one step is made"}
        assert (server.simulation.step_count, state(server)) == (before + count, SimulationState.PAUSED)


def test_steps_are_answered_after_the_last_and_publish_each(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")
    peer.listen(f"0/clock/{CLOCK}")
    peer.next(f"0/clock/{CLOCK}")
    before = server.simulation.step_count
    answer = peer.call_standard("StepSimulation", "step_simulation", steps=10)
    assert answer["result"]["result"] == OK
    assert server.simulation.step_count == before + 10
    for number in range(before + 1, before + 11):
        wanted = pytest.approx(number * 0.05)
        peer.next(f"0/clock/{CLOCK}", lambda sent, wanted=wanted: seconds(sent.value["clock"]) == wanted)
    assert state(server) is SimulationState.PAUSED


def test_reset_restores_the_start_and_keeps_running_or_pausing(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    server.wait_until(lambda: server.simulation.step_count > 50)
    server.on_server(server.simulation.pause)
    assert peer.trigger("reset") == {"success": True, "message": "the simulation is reset"}
    assert (server.simulation.step_count, state(server)) == (0, SimulationState.PAUSED)
    peer.trigger("start")
    assert peer.call_standard("ResetSimulation", "reset_simulation", scope=0)["result"]["result"] == OK
    assert state(server) is SimulationState.RUNNING


def test_the_standards_states_and_transitions(server: Ros2World) -> None:
    peer = server.peer()

    def get() -> int:
        answer = peer.call_standard("GetSimulationState", "get_simulation_state")
        assert answer["result"]["result"] == OK
        return answer["state"]["state"]

    def put(wanted: int) -> int:
        answer = peer.call_standard("SetSimulationState", "set_simulation_state", state={"state": wanted})
        assert bool(answer["result"]["error_message"]) == (answer["result"]["result"] != OK)
        return answer["result"]["result"]

    assert get() == STOPPED
    assert put(PAUSED) == 103
    assert put(PLAYING) == OK
    assert get() == PLAYING
    assert put(PLAYING) == 101
    assert put(PAUSED) == OK
    assert get() == PAUSED
    assert put(STOPPED) == OK
    assert put(3) == 102  # the test's simulation belongs to no program that could end
    assert put(200) == UNSUPPORTED
    assert get() == STOPPED


@pytest.mark.parametrize("scope", [1, 2, 5, 77])
def test_a_partial_reset_is_not_supported_and_changes_nothing(server: Ros2World, scope: int) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")
    before = server.simulation.step_count
    answer = peer.call_standard("ResetSimulation", "reset_simulation", scope=scope)["result"]
    assert answer["result"] == UNSUPPORTED
    assert "SCOPE_ALL" in answer["error_message"]
    assert server.simulation.step_count == before


@pytest.mark.parametrize("steps", [0, 10**18])
def test_a_senseless_number_of_steps_is_refused(server: Ros2World, steps: int) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")
    answer = peer.call_standard("StepSimulation", "step_simulation", steps=steps)["result"]
    assert answer["result"] == FAILED
    assert "from 1 to" in answer["error_message"]


def test_steps_while_it_runs_are_an_incorrect_state(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    answer = peer.call_standard("StepSimulation", "step_simulation", steps=1)["result"]
    assert answer["result"] == INCORRECT_STATE


@pytest.mark.parametrize(("verb", "expected"), [("stop", STOPPED), ("pause", PAUSED), ("start", PLAYING)])
def test_many_steps_end_with_another_request(server: Ros2World, verb: str, expected: int) -> None:
    peer, other = server.peer(), server.peer()
    peer.trigger("start")
    peer.trigger("pause")
    before = server.simulation.step_count
    answers: list[Any] = []

    def ask() -> None:
        answers.append(peer.call_standard("StepSimulation", "step_simulation", steps=1_000_000))

    asking = threading.Thread(target=ask)
    asking.start()
    server.wait_until(lambda: server.simulation.step_count > before + 3)
    present = other.call_standard("GetSimulationState", "get_simulation_state")
    assert present["state"]["state"] == PAUSED
    assert other.trigger(verb)["success"]
    asking.join(30)
    assert answers[0]["result"]["result"] == FAILED
    assert "before all steps were made" in answers[0]["result"]["error_message"]
    present = other.call_standard("GetSimulationState", "get_simulation_state")
    assert present["state"]["state"] == expected
    if verb == "start":
        count = server.simulation.step_count
        server.wait_until(lambda: server.simulation.step_count > count + 3)


def test_steps_that_diverge_end_with_the_reason(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")
    answers: list[Any] = []
    asking = threading.Thread(
        target=lambda: answers.append(
            peer.call_standard("StepSimulation", "step_simulation", steps=1_000_000)
        )
    )
    asking.start()
    server.wait_until(lambda: server.simulation.step_count > 3)
    server.simulation.data.qvel[0] = float("nan")
    asking.join(30)
    assert answers[0]["result"]["result"] == FAILED
    assert "the physics diverged" in answers[0]["result"]["error_message"]


def test_requests_for_steps_beyond_those_that_wait_are_refused(
    server: Ros2World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_server.gateways.ros2.content.run.MOST_REQUESTS", 2)
    run = next(each._run for each in server.gateway._contents if isinstance(each, Control))
    peers = [server.peer() for _ in range(2)]
    peers[0].trigger("start")
    peers[0].trigger("pause")
    answers: list[Any] = []

    def ask(peer: Peer) -> None:
        answers.append(peer.call_standard("StepSimulation", "step_simulation", steps=1_000_000))

    asking = [threading.Thread(target=ask, args=(peer,)) for peer in peers]
    for each in asking:
        each.start()
    server.wait_until(lambda: len(run._steps) == 2)
    other = server.peer()
    refused = other.trigger("step")
    assert not refused["success"]
    assert "2 requests for steps wait already" in refused["message"]
    assert answers == []
    assert other.trigger("stop")["success"]
    for each in asking:
        each.join(30)
    assert [answer["result"]["result"] for answer in answers] == [FAILED] * 2


def test_steps_wait_for_another_client_that_steps_too(server: Ros2World) -> None:
    peer = server.peer()
    peer.trigger("start")
    peer.trigger("pause")

    other: ClientSession = server.on_server(
        lambda: server.loop.service.clients.join("other", "other", 1, Link())
    )
    server.on_server(lambda: other.set_stepping(True))
    asking = threading.Thread(target=lambda: peer.trigger("step"))
    before = server.simulation.step_count
    asking.start()
    server.wait_until(lambda: server.simulation.state is SimulationState.RUNNING)
    assert server.simulation.step_count == before
    server.on_server(lambda: other.trigger(is_running=True))
    asking.join(30)
    assert not asking.is_alive()
    assert server.simulation.step_count == before + 1
    server.on_server(lambda: server.loop.service.clients.leave("other"))


def test_humble_calls_the_same_services(server: Ros2World) -> None:
    key = "0/simx/start/std_srvs::srv::dds_::Trigger_/TypeHashNotSupported"
    ((payload, _),) = server.peer().ask(key, bytes.fromhex("0001000000"), attachment())
    assert payload[4] == 1


def test_a_request_without_valid_attachment_or_hash_ends_without_answer(
    server: Ros2World, caplog: pytest.LogCaptureFixture
) -> None:
    peer, empty = server.peer(), bytes.fromhex("0001000000")
    assert peer.ask(f"0/simx/start/{TRIGGER}", empty, None) == []
    assert peer.ask(f"0/simx/start/{TRIGGER}", empty, bytes(12)) == []
    wrong = f"0/simx/start/std_srvs::srv::dds_::Trigger_/RIHS01_{'1' * 64}"
    assert peer.ask(wrong, empty, attachment()) == []
    assert state(server) is SimulationState.STOPPED
    assert "33 bytes" in caplog.text
    assert "knows another std_srvs/srv/Trigger" in caplog.text


def test_a_request_for_many_services_at_once_calls_none(
    server: Ros2World, caplog: pytest.LogCaptureFixture
) -> None:
    key, empty = f"0/simx/*/{TRIGGER}", bytes.fromhex("0001000000")
    assert server.peer().ask(key, empty, attachment(), zenoh.QueryTarget.ALL) == []
    assert "one topic or service at a time" in caplog.text
    assert state(server) is SimulationState.STOPPED


def test_an_unreadable_request_is_answered_with_the_reason(
    server: Ros2World, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    peer = server.peer()
    ((payload, _),) = peer.ask(f"0/simx/start/{TRIGGER}", b"\0\1\0\0" + bytes(50), attachment())
    assert payload[4] == 0
    assert b"bytes" in payload
    assert state(server) is SimulationState.STOPPED


def test_requests_beyond_the_waiting_ones_are_refused_at_once(
    server: Ros2World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_server.gateways.ros2.wire.service.MOST_WAITING", 3)
    assert sorted(results_of_stops(server, 8)) == [0] * 5 + [1] * 3


def test_each_request_has_a_turn(server: Ros2World, monkeypatch: pytest.MonkeyPatch) -> None:
    desk = desk_of_stop(server)
    waiting, serve, taken = desk.service._waiting, desk.serve, list[int]()

    def counted() -> None:
        before = len(waiting)
        serve()
        taken.append(before - len(waiting))

    monkeypatch.setattr(desk, "serve", counted)
    assert results_of_stops(server, 3) == [1, 1, 1]
    server.wait_until(lambda: taken == [1, 1, 1])


def end_search(server: Ros2World, stop: Callable[[Peer], object]) -> bool:
    """Return whether a request ends a search, as planners make them, that holds the physics thread."""
    peer, has_begun, ends = server.peer(), threading.Event(), list[bool]()
    peer.trigger("start")

    def search() -> None:
        interruptions, limit = server.simulation.interruptions, time.monotonic() + 20
        while (may_go_on := interruptions.may_go_on()) and time.monotonic() < limit:
            has_begun.set()
        ends.append(not may_go_on)

    server.loop.service.queue.post(search)
    assert has_begun.wait(20)
    stop(peer)
    server.wait_until(lambda: bool(ends))
    return ends[0]


def test_a_stop_ends_a_search(server: Ros2World) -> None:
    assert end_search(server, lambda peer: peer.trigger("stop"))
    standard = {"state": {"state": STOPPED, "transition_id": 0}}
    assert end_search(
        server, lambda peer: peer.call_standard("SetSimulationState", "set_simulation_state", **standard)
    )


def test_a_request_to_quit_ends_a_search_too(server: Ros2World) -> None:
    desks = server.gateway._offered.desks
    (desk,) = [each for each in desks if each.offer.service == "/set_simulation_state"]
    assert [desk.offer.stops({"state": {"state": wanted}}) for wanted in range(4)] == [
        True,
        False,
        False,
        True,
    ]


def desk_of_stop(server: Ros2World) -> Desk:
    return next(each for each in server.gateway._offered.desks if each.offer.service == "~/stop")


def results_of_stops(server: Ros2World, count: int) -> list[int]:
    """Success or failure of this many calls that arrive before the first of them is executed."""
    peer, may_go_on = server.peer(), threading.Event()
    server.loop.service.queue.post(may_go_on.wait)
    replies = [
        peer.session.get(
            f"0/simx/stop/{TRIGGER}",
            payload=bytes.fromhex("0001000000"),
            attachment=attachment(number),
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=30.0,
        )
        for number in range(1, count + 1)
    ]
    arrived = desk_of_stop(server).service._waiting
    wait_for(lambda: len(arrived) == count)
    may_go_on.set()
    return [reply.ok.payload.to_bytes()[4] for each in replies for reply in each if reply.ok is not None]


def wait_for(condition: Any) -> None:
    looks = threading.Event()
    for _ in range(3000):
        if condition():
            return
        looks.wait(0.01)
    raise AssertionError("it does not come true")


def test_a_server_that_ends_leaves_the_graph(tmp_path: Path) -> None:
    with ros2_world(tmp_path) as server:
        peer = server.peer()
        peer.watch()
        peer.wait_for_token(lambda token: "/NN/" in token)
        assert peer.trigger("start")["success"]
