"""After a crash: the start of the next server, the clients it waits for, its messages, and when none starts."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from past_lab import MACHINE, Lab
from real_world import BLOCKING
from recordings import RecordedWorld, replay

import simx_client as v
from simx_client.protocol.cli.exit_codes import DIVERGED, DONE
from simx_server.history import succession
from simx_server.history.journal import Block, Journal
from simx_server.history.succession import Inheritance, Succession, take_over
from simx_server.history.writing import Kind
from simx_server.recording import Recorder
from simx_server.recording.replayed import Replayed
from simx_server.service.clients.returning import Returning
from simx_server.simulation.simulation import SimulationState

CRASH = -signal.SIGSEGV


class Clock:
    now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(succession, "time", clock)
    return clock


@pytest.fixture
def line(clock: Clock) -> Iterator[Succession]:
    one = Succession()
    one.first()
    yield one
    one.close()


def serve_until(line: Succession, step: int) -> None:
    """A server that gets ready and keeps the moment of a step."""
    line.is_ready()
    line.journal.restart([Block(Kind.STOPPED, 0, b""), Block(Kind.STEP, step, b"")])


def next_back(line: Succession) -> int | None:
    following = line.next(CRASH)
    return None if following is None else following.back


def test_crashes_at_different_moments_lose_nothing_however_many_there_are(line: Succession) -> None:
    for step in range(10, 100, 10):
        serve_until(line, step)
        assert next_back(line) == 0


def test_who_crashes_at_once_at_the_same_moment_goes_back_further_and_at_last_ends(line: Succession) -> None:
    serve_until(line, 10)
    following = line.next(CRASH)
    assert following is not None
    assert (following.back, following.ended) == (0, "by signal 11 (SIGSEGV)")
    for back in (1, 2):
        serve_until(line, 11)
        assert next_back(line) == back
    serve_until(line, 10)
    assert next_back(line) is None


def test_the_same_moment_a_while_later_is_another_crash(line: Succession, clock: Clock) -> None:
    for _ in range(5):  # of a simulation that is paused
        serve_until(line, 10)
        clock.now += succession.AT_ONCE
        assert next_back(line) == 0


def test_a_start_that_fails_in_good_order_is_tried_again_for_a_while(line: Succession) -> None:
    serve_until(line, 10)
    assert next_back(line) == 0
    for _ in range(succession.MOST_FAILURES):
        following = line.next(1)
        assert following is not None
        assert (following.back, following.ended) == (0, "by signal 11 (SIGSEGV)")
        assert line.pause == succession.PAUSE
    assert line.next(1) is None


class Servers:
    """One server after the other, with a recording that goes on."""

    def __init__(self, open_lab: Callable[[str], Lab], monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("simx_server.history.keeping.SHARE", 1.0)
        self.open_lab = open_lab
        self.journal = Journal()

    def begin(self, lab: Lab, back: int | None = None) -> None:
        ended = "" if back is None else "by signal 11"
        take_over(lab.loop.service, Inheritance(self.journal, ended, back or 0), None)


@pytest.fixture
def servers(open_lab: Callable[[str], Lab], monkeypatch: pytest.MonkeyPatch) -> Iterator[Servers]:
    one = Servers(open_lab, monkeypatch)
    yield one
    v.simxFinish(-1)


def test_it_is_told_in_the_status_bar_and_to_the_clients_that_come_back(servers: Servers) -> None:
    first = servers.open_lab(MACHINE)
    servers.begin(first)
    first.start()
    first.run_to(4)
    (former,) = first.loop.service.clients.sessions
    second = servers.open_lab(first.scene_path)
    servers.begin(second, back=0)
    told = "the server ended by signal 11 and was started again; the simulation goes on from step 4, 0.200 s"
    assert second.parts.status_bar.messages[-1] == told
    session = second.loop.service.clients.join(
        former,
        "drv.py",
        19997,
        second.loop.service.clients.sessions[next(iter(second.loop.service.clients.sessions))].link,
    )
    assert list(session.errors) == [told]
    assert session.is_stepping
    assert session is second.loop.service.clients.sessions[former]
    newcomer = second.loop.service.clients.join("newcomer", "other.py", 19997, session.link)
    assert not newcomer.errors
    assert not newcomer.is_stepping


def test_who_has_not_come_back_before_the_next_crash_is_expected_after_it(servers: Servers) -> None:
    first = servers.open_lab(MACHINE)
    servers.begin(first)
    first.start()
    first.run_to(4)
    (former,) = first.loop.service.clients.sessions
    for _ in range(2):
        successor = servers.open_lab(first.scene_path)
        successor.loop.service.clients.sessions.clear()
        servers.begin(successor, back=0)
        assert [*successor.loop.service.returning.awaited()] == [former]
        assert successor.loop.service.returning.seconds_left() > 0


def test_what_cannot_be_continued_is_told_and_the_scene_is_as_it_was_loaded(servers: Servers) -> None:
    lab = servers.open_lab(MACHINE)
    servers.journal.restart([])
    servers.begin(lab, back=0)
    assert "nothing was kept, so the scene is as it was loaded" in lab.parts.status_bar.messages[-1]
    assert lab.sim.state is SimulationState.STOPPED


def test_the_simulation_waits_for_who_stepped_it_but_not_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock()
    monkeypatch.setattr("simx_server.service.clients.returning.time", clock)
    returning = Returning()
    returning.expect({"one": ("drv.py", False)}, "")
    assert returning.seconds_left() == 0.0
    returning.expect({"one": ("drv.py", True)}, "")
    assert returning.seconds_left() > 0
    clock.now += 10.0
    assert returning.seconds_left() == 0.0


@pytest.mark.parametrize("torn", [0, 30])
def test_a_recording_goes_on_after_a_crash_and_replays_equal(
    torn: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_server.history.keeping.SHARE", 1.0)
    scene, recording = tmp_path / "machine.xml", tmp_path / "run.simxlog"
    scene.write_text(MACHINE)
    journal = Journal()
    first = AgainRecorded(scene, recording, Inheritance(journal))
    drive(first, 7)
    first.crash(journal)
    os.truncate(recording, recording.stat().st_size - torn)
    second = AgainRecorded(scene, recording, Inheritance(journal, "by signal 11"))
    assert second.simulation.step_count == 7
    drive(second, 12)
    second.close()
    journal.close()
    assert replay(recording) == DONE
    # It would be noticed if the replay did not begin where the second server did.
    monkeypatch.setattr(Replayed, "resume", lambda *_: None)
    assert replay(recording) == DIVERGED


class AgainRecorded(RecordedWorld):
    """A server that records and keeps its world; or its successor."""

    def __init__(self, scene: Path, recording: Path, inheritance: Inheritance) -> None:
        is_next = bool(inheritance.ended)
        monkey = pytest.MonkeyPatch()
        monkey.setattr("recordings.Recorder", lambda path, chosen: Recorder(path, chosen, goes_on=is_next))
        monkey.setattr(Recorder, "begin", lambda _recorder, _loop: None)
        try:
            super().__init__(scene, recording)
        finally:
            monkey.undo()
        take_over(self.loop.service, inheritance, self._recorder)

    def crash(self, journal: Journal) -> None:
        """End as a process does that is gone at once: nothing more is kept or recorded."""
        kept = journal.read()
        self._recorder._log.close()
        self._recorder._log.has_failed = True
        v.simxFinish(-1)
        self._stack.close()
        journal.restart(kept)


def drive(place: RecordedWorld, step: int) -> None:
    client = place.client()
    assert v.simxSynchronous(client, True) == 0
    v.simxStartSimulation(client, BLOCKING)
    spin = v.simxGetObjectHandle(client, "spin", BLOCKING)[1]
    copies: list[int] = []
    while place.simulation.step_count < step:
        v.simxSetJointTargetVelocity(client, spin, 0.3 * place.simulation.step_count, BLOCKING)
        v.simxSetFloatSignal(client, "gain", 0.5 * place.simulation.step_count, BLOCKING)
        if not copies:
            ball = v.simxGetObjectHandle(client, "ball", BLOCKING)[1]
            copies = v.simxCopyPasteObjects(client, [ball], BLOCKING)[1]
        v.simxSynchronousTrigger(client)
