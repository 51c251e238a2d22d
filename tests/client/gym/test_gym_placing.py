"""Where the simulations of a vector environment run without a number of processes: a measurement decides."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import pytest

from simx_client.client.servers import Servers
from simx_client.gym import SimxVectorEnv, load_task
from simx_client.gym.running import placing
from simx_client.gym.task import Task

pytestmark = [pytest.mark.slow, pytest.mark.gl]

CART_POLE = load_task("cart_pole")
MILLISECOND = 1e-3


@contextmanager
def started(
    count: int = 2, processes: int | None = None, threads: int | None = 0, **settings: object
) -> Iterator[placing.Place]:
    with ExitStack() as stack:
        yield placing.start(CART_POLE, count, placing.Wanted(processes, threads), 5.0, settings, stack)


def taking(monkeypatch: pytest.MonkeyPatch, alone: float, together: float) -> None:
    """Have a step of one simulation, and one of several in workers, take these seconds."""

    def seconds(_: Task, servers: Servers) -> float:
        return alone if len(servers) == 1 else together

    monkeypatch.setattr(placing, "seconds_per_step", seconds)
    monkeypatch.setattr(placing, "cores", lambda: 2)


def test_short_steps_stay_in_this_process_and_long_ones_get_workers() -> None:
    assert placing.choice(0.05 * MILLISECOND, 2)[0] == 0
    assert placing.choice(100 * MILLISECOND, 2)[0] == 2
    assert placing.choice(1 * MILLISECOND, 2)[0] is None


@pytest.mark.parametrize(
    ("alone", "together", "backend"),
    [
        (10.0, 0.0, "2 worker processes: a step of all takes 20.00 ms in one process"),
        (
            0.01,
            0.0,
            "this process: a step of all takes 0.02 ms in one process, which workers cannot make shorter",
        ),
        (1.0, 0.5, "2 worker processes: a step of all takes 2.00 ms in one process, 0.50 ms in 2 workers"),
        (1.0, 2.5, "this process: a step of all takes 2.00 ms in one process, 2.50 ms in 2 workers"),
    ],
    ids=["long", "short", "faster in workers", "slower in workers"],
)
def test_the_faster_place_is_chosen(
    monkeypatch: pytest.MonkeyPatch, alone: float, together: float, backend: str
) -> None:
    taking(monkeypatch, alone * MILLISECOND, together * MILLISECOND)
    with started() as (servers, where, threads):
        assert where == backend
        assert len(servers) == 2
        assert threads == 0


def test_the_reason_is_said_where_nothing_was_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    with started(processes=0) as (_, where, _):
        assert where == "this process: as `processes` says"
    with started(count=1) as (_, where, _):
        assert where == "this process: one simulation"
    monkeypatch.setattr(placing, "cores", lambda: 1)
    with started() as (_, where, _):
        assert where == "this process: one processor core"


def test_threads_are_used_where_scene_and_task_allow_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(placing, "cores", lambda: 2)
    whole = "compiled code does everything of a step"
    for count, processes, wanted, threads in [
        (3, None, None, 2),
        (3, 0, None, 2),
        (1, None, None, 1),
        (3, None, 3, 3),
    ]:
        with started(count, processes, wanted) as (servers, where, used):
            assert where == f"{threads} thread{'s' * (threads > 1)} of this process: {whole}"
            assert (len(servers), used) == (count, threads)
    with started(1, history=5, threads=None) as (_, where, threads):
        assert (where, threads) == ("this process: one simulation", 0)
    with started(2, 0, None, history=5) as (_, where, threads):
        assert where == "this process: other clients, a recording or a history see each step"
        assert threads == 0


@pytest.mark.parametrize(
    ("seconds", "physics", "together", "backend"),
    [
        (
            1.0,
            0.7,
            9.0,
            "2 threads of this process: compiled code makes the physics, Python the rest of a step",
        ),
        (
            1.0,
            0.2,
            9.0,
            "2 threads of this process: compiled code makes the physics, Python the rest of a step",
        ),
        (1.5, 0.2, 9.0, "this process: a step of all takes 2.00 ms in one process, 9.00 ms in 2 workers"),
        (
            1.0,
            0.2,
            1.2,
            "2 worker processes: a step of all takes 2.00 ms in one process, 1.20 ms in 2 workers",
        ),
    ],
    ids=["much physics", "little physics, slow workers", "all slower than one by one", "little physics"],
)
def test_threads_for_the_physics_alone_where_that_is_much(
    monkeypatch: pytest.MonkeyPatch, seconds: float, physics: float, together: float, backend: str
) -> None:
    taking(monkeypatch, MILLISECOND, together * MILLISECOND)
    part = placing.Threaded(False, seconds * MILLISECOND, physics * MILLISECOND)
    monkeypatch.setattr(placing, "try_threads", lambda _task, _alone: part)
    with started(threads=None) as (_, where, _):
        assert where == backend


def test_an_environment_tells_its_backend() -> None:
    environment = SimxVectorEnv(CART_POLE, 2, processes=1)
    assert environment.backend == "1 worker process: as `processes` says"
    environment.reset(seed=1)
    environment.step(environment.action_space.sample())
    environment.close()
