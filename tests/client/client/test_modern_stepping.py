"""Stepped mode with one message a pass, and calls that go out together, of ``simx_client.Client``."""

from __future__ import annotations

import numpy as np
import pytest
from modern_world import messages_of

import simx_client as v
from simx_client import Client, batch, errors
from simx_client.client import Servers


def test_the_simulation_tells_state_and_time(client: Client) -> None:
    simulation = client.simulation
    assert (simulation.state, simulation.time) == ("stopped", 0)
    simulation.time_step = 0.01
    assert simulation.time_step == 0.01
    simulation.start()
    assert simulation.state == "running"
    with pytest.raises(errors.SimxError, match="stop it first"):
        simulation.time_step = 0.02
    simulation.pause()
    assert simulation.state == "paused"
    simulation.stop()
    assert (simulation.state, simulation.time) == ("stopped", 0)


# --- stepping and together ---------------------------------------------------------------------------


def test_a_pass_with_all_that_is_set_and_watched_is_one_message(client: Client) -> None:
    both, tip, eye = client.joints("shoulder", "wrist"), client.dummy("tip"), client.proximity_sensor("eye")
    with client.stepping(lambda: (both.positions, tip.position, client.simulation.time)) as step:
        assert step.latest[2] == 0
        sizes = messages_of(client)
        for turn in range(1, 4):
            both.target_positions = [0.1 * turn, 0.0]
            positions, where, seconds = step()
            assert seconds == pytest.approx(0.05 * turn)
        assert sizes == [2 + 1 + 4] * 3
        assert positions == pytest.approx(both.positions)
        assert where == pytest.approx(tip.position)
        assert eye.read() is not None


def test_stepping_again_gives_the_same_numbers_and_leaves_the_simulation_as_it_was(client: Client) -> None:
    shoulder = client.joint("shoulder")

    def run() -> list[float]:
        shoulder.target_position = 1.0
        return [step() for _ in range(5)]

    with client.stepping(lambda: shoulder.position) as step:
        first = run()
        assert step.restart() == 0.0
        assert run() == first
        assert first[-1] > 0.01
    assert client.simulation.state == "stopped"
    client.simulation.start()
    client.simulation.pause()
    with client.stepping():
        assert client.simulation.state == "running"
    assert client.simulation.state == "paused"
    client.simulation.start()
    with client.stepping():
        pass
    assert client.simulation.state == "running"
    assert v.simxSynchronousTrigger(client.id) == v.simx_return_remote_error_flag, "stepped mode is over"


def test_what_is_watched_may_change_and_may_be_missing(client: Client) -> None:
    seen: list[str] = ["shoulder"]
    with client.stepping(
        lambda: ([client.joint(n).position for n in seen], client.signals.get("s", None))
    ) as step:
        assert step() == ([pytest.approx(0)], None)
        seen.append("wrist")
        client.signals["s"] = 2
        assert step() == ([pytest.approx(0), pytest.approx(0)], 2)


def test_images_come_with_the_step_too_and_show_what_the_step_left(client: Client) -> None:
    camera, red = client.camera("above"), client.object("red")
    with client.stepping(lambda: (camera.rgb(), camera.depth())) as step:
        sizes = messages_of(client)
        for x in (-0.5, 0.5):
            red.position = [x, 0.3, 0.5]
            picture, depth = step()
            columns = np.nonzero((picture[:, :, 0] > 100) & (depth < 2.2))[1]
            assert (columns.mean() < 32) == (x < 0)
        assert sizes == [1 + 1 + 4] * 2


def test_an_exception_within_stepping_ends_it_and_comes_out(client: Client) -> None:
    def program() -> None:
        with client.stepping():
            client.joint("shoulder").position = 0.5
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        program()
    assert client.simulation.state == "stopped"
    assert client.joint("shoulder").position == 0.0, "what was set was dropped"


def test_a_watch_that_fails_leaves_nothing_behind(client: Client) -> None:
    with pytest.raises(errors.NoSuchObject), client.stepping(lambda: client.joint("none").position):
        pass
    assert client.simulation.state == "stopped"
    with client.stepping(lambda: client.simulation.time) as step:
        assert step() == pytest.approx(0.05)


def test_stepping_does_not_nest(client: Client) -> None:
    with client.stepping(), pytest.raises(RuntimeError, match="stepping already"), client.stepping():
        pass


def test_together_is_one_message_in_order_and_reads_see_what_was_set(client: Client) -> None:
    shoulder, wrist = client.joints("shoulder", "wrist")
    sizes = messages_of(client)
    with client.together():
        shoulder.position = 0.1
        wrist.position = 0.2
    with client.together():
        shoulder.position = 0.3
        assert shoulder.position == pytest.approx(0.3)
    assert sizes == [2, 2]


def test_what_is_watched_without_stepping_is_one_message_from_the_second_time_on(client: Client) -> None:
    both, tip = client.joints("shoulder", "wrist"), client.dummy("tip")
    look = client.watching(lambda: (both.positions, tip.pose))
    look()
    sizes = messages_of(client)
    both.positions = [0.5, 0.25]
    positions, pose = look()
    assert sizes == [2, 4]
    assert positions == pytest.approx([0.5, 0.25])
    assert pose.position == pytest.approx(tip.position)


def test_a_refusal_of_what_was_set_is_not_taken_for_one_of_what_is_read(client: Client) -> None:
    red, blue = client.object("red"), client.object("blue")
    for read in (
        lambda: client.joint("wrist"),
        lambda: client.signals.ints.get("it", 0),
        lambda: blue.position,
    ):
        with client.together():
            red.parent = blue
            with pytest.raises(errors.RemoteError, match="simxSetObjectParent") as told:
                read()
        assert type(told.value) is errors.RemoteError


def test_an_exception_within_together_drops_what_was_not_sent(client: Client) -> None:
    shoulder = client.joint("shoulder")

    def program() -> None:
        with client.together():
            shoulder.position = 0.5
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        program()
    assert shoulder.position == 0.0


def test_a_batch_is_one_message_behind_what_is_held_back(client: Client) -> None:
    shoulder = client.joint("shoulder")
    sizes = messages_of(client)
    with client.together():
        client.signals.ints["before"] = 1
        with client.batch() as calls:
            before = calls.simxGetIntegerSignal("before")
            calls.simxSetJointPosition(shoulder.handle, 0.25)
            place = calls.simxGetJointPosition(shoulder.handle)
        assert (before.value, place.value) == (1, pytest.approx(0.25))
    assert sizes == [4]


def test_a_refused_call_of_a_batch_is_raised_unless_it_is_looked_at(client: Client) -> None:
    with pytest.raises(errors.RemoteError, match="simxGetJointPosition"), client.batch() as calls:
        calls.simxGetJointPosition(999)
    with client.batch(check=False) as calls:
        position = calls.simxGetJointPosition(999)
    assert position.code


def test_an_exception_within_a_batch_drops_its_calls(client: Client) -> None:
    with pytest.raises(ZeroDivisionError), client.batch() as calls:
        calls.simxSetIntegerSignal("never", 1 // 0)
    assert client.signals.ints.get("never", 0) == 0


def test_many_clients_are_the_servers_of_batch() -> None:
    with pytest.raises(errors.ConnectionFailed, match="no connection to server 0 at "):
        Client.many([1], timeout=0.1)
    assert batch.Servers is Servers
