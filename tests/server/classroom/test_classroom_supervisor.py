"""The supervisor of a class: pauses between starts, what it does when no process can be made, messages of the page."""

from __future__ import annotations

import errno
import os
import select
import signal
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from functools import partial

import pytest

from simx_server.classroom import channel, member
from simx_server.classroom.member import PAUSES, Member
from simx_server.classroom.plan import ClassPlan, Seat
from simx_server.classroom.supervisor import PAGE, RETRY, Supervisor
from simx_server.history.journal import Block
from simx_server.history.succession import Succession
from simx_server.history.writing import Kind
from simx_server.settings.settings import Settings

pytestmark = pytest.mark.slow

if sys.platform != "linux":
    pytest.skip("classes run on Linux", allow_module_level=True)

SOON = 60.0


class Clock:
    """A clock that the test moves."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(member, "time", clock)
    return clock


def started(one: Member, program: str = "/bin/true") -> Member:
    reader, writer = os.pipe()
    os.close(writer)
    here, there = channel.pair()
    there.close()
    one.begin(os.posix_spawn(program, [program, "1000"], {}), reader, here)
    return one


def test_process_that_ends_soon_again_and_again_is_started_after_growing_pauses(clock: Clock) -> None:
    one = Member(1)
    pauses: list[float] = []
    for _ in range(len(PAUSES) + 1):
        clock.now += 1.0
        assert started(one).bury() == 0
        pauses.append(one.start_at - clock.now)
    assert pauses == [*PAUSES[1:], PAUSES[-1], PAUSES[-1]]
    started(one)
    clock.now += member.STEADY
    one.bury()
    assert one.start_at == clock.now


def test_process_that_was_told_to_end_is_started_again_at_once(clock: Clock) -> None:
    one = started(Member(1), "/bin/sleep")
    one.end("the seat was reset")
    one.end("another reason")
    assert one.reason == "the seat was reset"
    assert one.kill_at == clock.now + member.GRACE
    assert one.bury() == -signal.SIGTERM
    assert one.start_at == clock.now
    assert not one.is_running


def test_reset_ends_the_pause_before_the_next_start(clock: Clock) -> None:
    one = started(Member(1))
    one.bury()
    assert one.start_at > clock.now
    one.end("the seat was reset")
    assert one.start_at == clock.now


def test_seat_that_crashes_goes_on_at_once_and_starts_with_the_scene_of_the_class_after_a_reset(
    clock: Clock,
) -> None:
    seat = Member(1, Succession())
    assert seat.inheritance is not None
    for step in (5, 90, 200):  # it made progress each time
        started(seat, "/bin/sleep").note_ready()
        seat.inheritance.journal.restart([Block(Kind.STOPPED, 0, b""), Block(Kind.STEP, step, b"")])
        seat.kill()
        assert seat.bury() == -signal.SIGKILL
        assert seat.start_at == clock.now
        assert (seat.inheritance.ended, seat.inheritance.back) == ("by signal 9 (SIGKILL)", 0)
    started(seat, "/bin/sleep").end("the seat was reset")
    seat.bury()
    assert not seat.inheritance.ended
    assert not seat.inheritance.journal.read()
    seat.close()


def test_seat_that_crashes_at_the_same_moment_again_and_again_starts_with_the_scene_of_the_class_after_a_pause(
    clock: Clock,
) -> None:
    seat = Member(1, Succession())
    assert seat.inheritance is not None
    backs: list[int] = []
    for _ in range(4):
        started(seat, "/bin/sleep").note_ready()
        seat.inheritance.journal.restart([Block(Kind.STOPPED, 0, b""), Block(Kind.STEP, 5, b"")])
        seat.kill()
        seat.bury()
        backs.append(seat.inheritance.back if seat.inheritance.ended else -1)
    assert backs == [0, 1, 2, -1]
    assert seat.start_at > clock.now
    seat.close()


@pytest.fixture
def supervisor() -> Iterator[Supervisor]:
    """Of one seat; nothing has started."""
    seats = (Seat(1, "", "seat-01", "token-of-seat-1", 20_001, Settings()),)
    with ExitStack() as stack:
        listener = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        signals, sender = (stack.enter_context(end) for end in socket.socketpair())
        assert sender.fileno() >= 0  # open: a closed one would count as a signal
        plan = ClassPlan(seats, "token-of-teacher", "127.0.0.1", None)
        one = Supervisor(plan, None, listener, signals.fileno(), 1 << 30)
        stack.callback(one.close)
        yield one


def test_system_without_room_for_a_process_is_asked_again_later(
    supervisor: Supervisor, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fork() -> int:
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    monkeypatch.setattr(os, "fork", fork)
    before, now = len(os.listdir("/proc/self/fd")), time.monotonic()
    supervisor._start_due()
    assert len(os.listdir("/proc/self/fd")) == before
    assert all(not each.is_running and each.start_at >= now + RETRY for each in supervisor._members.values())
    assert "seat-01 cannot be started now" in caplog.text
    assert "the page cannot be started now" in caplog.text


def test_seat_that_ends_before_it_is_ready_ends_the_start_of_the_class(
    supervisor: Supervisor, caplog: pytest.LogCaptureFixture
) -> None:
    supervisor._members[PAGE].is_ready = True
    for order in ((0, 1), (1, 0)):  # the system reports both ends of the process in any order
        seat = started(supervisor._members[1])
        supervisor._selector.register(seat.reader, 1, partial(supervisor._on_ready, seat))
        supervisor._selector.register(seat.death, 1, partial(supervisor._on_death, seat))
        handlers = partial(supervisor._on_ready, seat), partial(supervisor._on_death, seat)
        assert select.select([seat.death], [], [], SOON)[0]
        for number in order:
            handlers[number](1)
        assert not seat.is_running
        assert not supervisor._open()
    assert "not ready: seat-01" in caplog.text


def test_messages_wait_for_a_page_that_reads_late(supervisor: Supervisor) -> None:
    here, page = channel.pair()
    with closing(page), closing(here):
        supervisor._page.open(here)
        for number in range(3000):
            supervisor._page.tell({"ready": number})
        for number in range(3000):
            while not select.select([page], [], [], 0)[0]:
                supervisor._wait(SOON)
            assert channel.unpacked(page.recv(4096)).fields == {"ready": number}
        supervisor._page.close()


@pytest.mark.parametrize(
    ("message", "ends"),
    [
        (b'{"reset": 1}', True),
        (b'{"reset": "all"}', True),
        (b'{"reset": 2}', False),
        (b'{"reset": [1]}', False),
        (b'{"reset": {"all": 1}}', False),
        (b"{}", False),
        (b"[]", False),
        (b"\xff\n", False),
    ],
)
def test_only_a_reset_of_a_seat_ends_it(supervisor: Supervisor, message: bytes, ends: bool) -> None:
    seat = started(supervisor._members[1], "/bin/sleep")
    here, page = channel.pair()
    with closing(page), closing(here):
        supervisor._page.open(here)
        page.send(message)
        supervisor._wait(SOON)
        assert (seat.reason == "the seat was reset") is ends
        supervisor._page.close()
    seat.kill()
    seat.bury()
