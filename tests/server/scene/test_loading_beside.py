"""A client's file is tried and read while the simulation goes on: only the client that loads it waits."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest
from loopback import LoopbackTransport
from processes import wait_until
from real_world import BLOCKING, RealWorld, handle_of
from scenes_for_tests import ARM

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_server.scene.finding import client_files
from simx_server.scene.finding.client_files import ClientFiles
from simx_server.scene.formats import model_files
from simx_server.scene.formats.sources import Sources
from simx_server.scene.trial.helper import Helper

ONESHOT, STREAMING = v.simx_opmode_oneshot, v.simx_opmode_streaming
CUBE = "<mujoco><worldbody><body name='brick'><geom size='.1 .1 .1' type='box'/></body></worldbody></mujoco>"


@pytest.fixture
def world(tmp_path: Path) -> Iterator[RealWorld]:
    folder = tmp_path / "server"
    folder.mkdir()
    (folder / "arm.xml").write_text(ARM)
    world = RealWorld(folder / "arm.xml", workspace=folder)
    yield world
    world.close()


@pytest.fixture
def loader(world: RealWorld, tmp_path: Path) -> int:
    """A client with its own file, `brick.xml`."""
    (tmp_path / "brick.xml").write_text(CUBE)
    return world.client()


@pytest.fixture
def other(world: RealWorld) -> int:
    return world.client()


@pytest.fixture
def file(tmp_path: Path) -> str:
    return str(tmp_path / "brick.xml")


@pytest.fixture
def go_on(monkeypatch: pytest.MonkeyPatch) -> Iterator[threading.Event]:
    """Trials wait for it."""
    may_go_on, ask = threading.Event(), Helper.ask

    def waiting(self: Helper, request: dict[str, object]) -> dict[str, object]:
        assert may_go_on.wait(20)
        return ask(self, request)

    monkeypatch.setattr(Helper, "ask", waiting)
    yield may_go_on
    may_go_on.set()


def comes_true(world: RealWorld, condition: Callable[[], bool], within: float = 60.0) -> bool:
    """Whether it does in time, while the loop turns as it always does.

    A call alone turns it once, for itself: where a load has taken long, the caller has the next turn too.
    """
    return wait_until(condition, within, lambda: world.loop.turn(max_wait=0.01))


def has_brick(client: int) -> bool:
    return v.simxGetObjectHandle(client, "brick", BLOCKING)[0] == 0


def errors_of(client: int) -> str:
    return "\n".join(v.simxGetLastErrors(client, BLOCKING)[1])


def test_the_simulation_runs_and_others_set_values_during_a_trial(world, loader, other, file, go_on) -> None:
    assert v.simxLoadModel(loader, file, 1, ONESHOT)[0] in (0, 1)
    assert v.simxStartSimulation(other, BLOCKING) == 0
    assert v.simxSetFloatSignal(other, "speed", 2.0, BLOCKING) == 0
    before = world.simulation.time
    assert v.simxGetObjectHandle(other, "brick", BLOCKING)[0] != 0
    for _ in range(5):
        assert v.simxGetPingTime(other)[0] == 0
    assert world.simulation.time > before
    go_on.set()
    assert comes_true(world, lambda: has_brick(other))


def test_others_are_answered_while_a_robot_of_the_operator_is_read(
    world: RealWorld, loader: int, other: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "server" / "brick.xml").write_text(CUBE)
    may_go_on, read = threading.Event(), model_files.read_model

    def waiting(*arguments: Any) -> Any:
        assert may_go_on.wait(20)
        return read(*arguments)

    monkeypatch.setattr(model_files, "read_model", waiting)
    assert v.simxLoadModel(loader, "brick.xml", 0, ONESHOT)[0] in (0, 1)
    for _ in range(5):
        assert v.simxGetPingTime(other)[0] == 0
    assert not has_brick(other)
    may_go_on.set()
    assert comes_true(world, lambda: has_brick(other))


def test_what_a_client_sends_behind_its_load_is_executed_after_it(loader, other, file, go_on) -> None:
    assert v.simxLoadModel(loader, file, 1, ONESHOT)[0] in (0, 1)
    assert v.simxSetIntegerSignal(loader, "later", 1, ONESHOT) in (0, 1)
    for _ in range(5):
        assert v.simxGetIntegerSignal(other, "later", BLOCKING)[0] != 0
    go_on.set()
    assert v.simxGetIntegerSignal(loader, "later", BLOCKING) == (0, 1)
    assert has_brick(loader)


def test_the_rest_of_a_paused_batch_comes_after_the_load(world, loader, other, file, go_on) -> None:
    assert v.simxTransferFile(loader, file, "brick.xml", 5000, BLOCKING) == 0
    v.simxPauseCommunication(loader, True)
    v.simxSetIntegerSignal(loader, "first", 1, ONESHOT)
    v.simxLoadModel(loader, "brick.xml", 0, ONESHOT)
    v.simxSetIntegerSignal(loader, "last", 1, ONESHOT)
    v.simxPauseCommunication(loader, False)
    assert comes_true(world, lambda: v.simxGetIntegerSignal(other, "first", BLOCKING) == (0, 1))
    assert v.simxGetIntegerSignal(other, "last", BLOCKING)[0] != 0
    go_on.set()
    assert v.simxGetIntegerSignal(loader, "last", BLOCKING) == (0, 1)
    assert has_brick(other)


def test_a_scene_is_refused_if_the_simulation_was_started_during_its_trial(
    world, loader, other, file, go_on
) -> None:
    assert v.simxLoadScene(loader, file, 1, ONESHOT) in (0, 1)
    assert v.simxStartSimulation(other, BLOCKING) == 0
    scene = world.simulation.scene
    go_on.set()
    assert "only while" in errors_of(loader)
    assert world.simulation.scene is scene


def test_nothing_is_left_of_a_client_that_goes_during_a_trial(
    world, loader, other, file, go_on, tmp_path
) -> None:
    before = sorted((tmp_path / "server").iterdir())
    connection = CLIENTS.get(loader)
    assert v.simxLoadModel(loader, file, 1, ONESHOT)[0] in (0, 1)

    def lent() -> bool:
        return v.simxGetPingTime(other)[0] == 0 and sorted((tmp_path / "server").iterdir()) != before

    def has_gone() -> bool:  # the client comes back on its own soon, in another session
        now = {id(session) for session in world.loop.service.clients.sessions.values()}
        return not all(id(session) in now for session in sessions)

    assert comes_true(world, lent), "else nothing was lent"
    assert connection is not None
    sessions = list(world.loop.service.clients.sessions.values())
    cast(LoopbackTransport, connection._transport).lose()
    go_on.set()
    assert comes_true(world, has_gone), "it leaves when its trial ends"
    assert comes_true(world, lambda: v.simxGetPingTime(other)[0] == 0 and not lent())


def test_a_load_that_is_under_way_when_the_loop_is_left_goes_on_with_the_next(
    world, loader, file, go_on
) -> None:
    assert v.simxLoadModel(loader, file, 1, ONESHOT)[0] in (0, 1)
    world.loop.run(deadline=time.monotonic())
    go_on.set()
    assert has_brick(loader)


def test_the_end_of_the_engine_gives_up_a_load(world, loader, file, go_on, tmp_path) -> None:
    before = sorted((tmp_path / "server").iterdir())
    assert v.simxLoadModel(loader, file, 1, ONESHOT)[0] in (0, 1)
    assert wait_until(lambda: world.loop.turn() or world.parts.trials._pool._used, 20)
    world.loop.service.clients.abandon_calls()
    assert sorted((tmp_path / "server").iterdir()) == before


def test_a_stream_loads_no_file_of_a_client(loader, file, tmp_path) -> None:
    assert v.simxTransferFile(loader, file, "brick.xml", 5000, BLOCKING) == 0
    assert v.simxLoadModel(loader, "brick.xml", 0, STREAMING)[0] in (1, 8)
    assert "by a stream; call it with a blocking mode" in errors_of(loader)
    assert not has_brick(loader)


def test_three_files_are_tried_at_a_time(world, loader, file, go_on) -> None:
    pool = world.parts.trials._pool
    clients = [world.client() for _ in range(4)]
    for each in clients:
        assert v.simxLoadModel(each, file, 1, ONESHOT)[0] in (0, 1)
    assert v.simxGetPingTime(world.client())[0] == 0
    assert comes_true(world, lambda: len(pool._used) >= 1)
    assert len(pool._used) <= 3
    go_on.set()
    assert comes_true(world, lambda: all(has_brick(each) for each in clients))
    assert handle_of(clients[0], "brick#2") >= 0


def test_a_file_can_be_stored_while_another_thread_looks_through_the_list_of_clients_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files, place = ClientFiles(tmp_path), client_files._place
    names = [tmp_path / name for name in ("one.obj", "two.obj", "three.obj")]
    for file in names[:2]:
        files.note(file, b"v 0 0 0")
        file.write_bytes(b"v 0 0 0")

    def store_meanwhile(path: Path | bytes) -> tuple[int, int] | None:
        files.note(names[2], b"v 1 1 1")
        return place(path)

    monkeypatch.setattr(client_files, "_place", store_meanwhile)
    assert files.are_named_by(names[0], Sources.of((), {}))
    assert files.holds(names[2], b"v 1 1 1")
