"""Environment steps per second: one server by the legacy loop and by batches, and 2, 4, 8 servers in lock-step.

A step writes the joints' targets, makes a pass and reads the joints and where the ball is. In the tutorial's scene
physics is most of it; in that of a small arm hardly any, so there it shows what the way to the servers costs.
"""

from __future__ import annotations

import json
import math
import subprocess
import sys
import time
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import simx_client as vrep
from bench.measuring.measure import Effort, Rounds, in_turn, ratio, repeated, timed
from bench.measuring.processes import ENDS_WITHIN_S, LONGEST_RUN_S, ROOT, NotReady
from bench.measuring.report import Findings, Ratio, Row
from bench.measuring.resources import processor_seconds
from bench.measuring.scheduling import cores
from simx_client import batch
from simx_server.app.server import open_world
from simx_server.settings.settings import Settings

from .client import CAMERA, JOINTS, check, connected, handle_of, running


@dataclass(frozen=True)
class Task:
    """What is moved and seen in a scene."""

    scene: str
    joints: tuple[str, ...]
    pose: tuple[float, ...]
    """The joints' targets, radians."""

    ball: str
    seen_from: str


TASKS = (
    Task("ur5_rg2_kinect", JOINTS, tuple(map(math.radians, (90, -45, 90, 0, -100, 0))), "Target", CAMERA),
    Task("two_link_arm", ("joint1", "joint2"), (0.5, 0.5), "target", "tip"),
)

COUNTS = (1, 2, 4, 8)
BLOCKING = "1 server by the legacy loop, blocking reads"
LEGACY = "1 server by the legacy loop, streams"
PASS = "a pass of the server's simulation in process"
TARGET = min(5.0, float(cores()))
"""Times the legacy loop's environment steps per second that many servers are to reach, with as many cores at most."""


def by_batch(count: int) -> str:
    return f"{count} server{'s' if count > 1 else ''} by batch"


@dataclass
class Work:
    """Processor time that one case has used so far, seconds, and for how many environment steps."""

    client: float = 0.0
    servers: float = 0.0
    steps: int = 0


@dataclass
class Case:
    """One way to step."""

    step: Callable[[], object]
    servers: Sequence[int] = ()
    """Process ids; empty for what happens in this process alone."""

    work: Work = field(default_factory=Work)

    def one_round(self, calls: int) -> tuple[float, ...]:
        timed(self.step, max(1, calls // 10))
        client, servers = time.process_time(), processor_seconds(self.servers)
        took = timed(self.step, calls)
        self.work.client += time.process_time() - client
        self.work.servers += processor_seconds(self.servers) - servers
        self.work.steps += calls * max(1, len(self.servers))
        return took


def measure(effort: Effort) -> Findings:
    """Both scenes, one after the other."""
    found = Findings("Many servers in lock-step", topic="Many clients and servers")
    for task in TASKS:
        work: dict[str, Work] = {}
        taken = repeated(max(1, effort.sets // 2), partial(_one_set, effort, task, work))
        _tell(found, task.scene, taken, work)
    return found


def _tell(found: Findings, scene: str, taken: dict[str, Rounds], work: dict[str, Work]) -> None:
    each = {name: _per_step(taken[name], name) for name in taken}
    most = by_batch(COUNTS[-1])
    for count in COUNTS:
        name = by_batch(count)
        found.ratios.append(
            Ratio(
                f"{scene}: an environment step, {name} / {LEGACY}",
                ratio(each[name], each[LEGACY]),
                target=1 / TARGET if name == most else None,
            )
        )
    found.ratios.append(
        Ratio(f"{scene}: an environment step, {most} / {BLOCKING}", ratio(each[most], each[BLOCKING]))
    )
    found.rows += [Row(f"{scene}: {name}", 1 / each[name].median, None, "1/s") for name in each]
    found.rows += [Row.of(f"{scene}: one step of all, {name}", taken[name], "us") for name in taken]
    for name, spent in work.items():
        for whose, seconds in (("client", spent.client), ("server", spent.servers)):
            if seconds:
                what = f"{scene}: processor time of the {whose} per environment step, {name}"
                found.rows.append(Row(what, seconds / spent.steps * 1e6, None, "us"))
    spent = (work[most].client + work[most].servers) / work[most].steps
    if spent:
        wanted = TARGET / each[LEGACY].median
        found.notes.append(
            f"{scene}: {most} spend {spent * 1e6:,.0f} us of processor time on an environment step; a pass alone takes "
            f"{each[PASS].median * 1e6:,.0f} us in process. {cores()} cores can therefore make {cores() / spent:,.0f} "
            f"steps per second; {TARGET:g} times the legacy loop's, {wanted:,.0f}, need {wanted * spent:.1f} cores."
        )


def _per_step(taken: Rounds, name: str) -> Rounds:
    """Seconds per environment step."""
    count = next((count for count in COUNTS if name == by_batch(count)), 1)
    return Rounds(tuple(tuple(value / count for value in values) for values in taken.values))


def _one_set(effort: Effort, task: Task, work: dict[str, Work], stack: ExitStack) -> dict[str, Rounds]:
    places = stack.enter_context(fleet(task.scene, 2 + sum(COUNTS)))
    cases: dict[str, Case] = {}
    for name, make in ((BLOCKING, _blocking), (LEGACY, _legacy)):
        port, process_id = places.pop()
        cases[name] = Case(stack.enter_context(make(task, port)), [process_id])
    for count in COUNTS:
        chosen = [places.pop() for _ in range(count)]
        step = stack.enter_context(lock_step(task, [port for port, _ in chosen]))
        cases[by_batch(count)] = Case(step, [process_id for _, process_id in chosen])
    simulation = open_world(Settings(scene=task.scene), stack)
    simulation.simulation.start()
    stack.callback(simulation.simulation.stop)
    cases[PASS] = Case(simulation.step)
    for name, case in cases.items():
        case.work = work.setdefault(name, Work())
    calls = effort.count(60)
    rounds = {name: partial(case.one_round, calls) for name, case in cases.items()}
    return in_turn(f"batch, {task.scene}", rounds, effort.rounds)


@contextmanager
def fleet(scene: str, count: int) -> Generator[list[tuple[int, int]]]:
    """So many servers by one command; gives port and process id of each."""
    command = [sys.executable, "-m", "simx_server", scene, "--count", str(count), "--port", "0", "-q"]
    command += ["--duration", str(LONGEST_RUN_S)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            if not line:
                raise NotReady(f"'{' '.join(command[1:])}' ended instead of getting ready")
            yield [(server["ports"][0], server["pid"]) for server in json.loads(line)["servers"]]
        finally:
            process.terminate()
            process.wait(2 * ENDS_WITHIN_S)


@contextmanager
def _prepared(task: Task, port: int) -> Generator[tuple[int, list[int], int, int]]:
    """A client in stepped mode, the arm in its pose: client id, joints, camera, ball."""
    with connected(port) as client:
        joints = [handle_of(client, name) for name in task.joints]
        camera, ball = handle_of(client, task.seen_from), handle_of(client, task.ball)
        with running(client, stepped=True):
            for joint, angle in zip(joints, task.pose, strict=True):
                check(vrep.simxSetJointPosition(client, joint, angle, vrep.simx_opmode_blocking))
            yield client, joints, camera, ball


@contextmanager
def _legacy(task: Task, port: int, mode: int = vrep.simx_opmode_buffer) -> Generator[Callable[[], None]]:
    """The loop of V-REP's documentation: oneshot targets, trigger, streamed reads."""
    with _prepared(task, port) as (client, joints, camera, ball):
        if mode == vrep.simx_opmode_buffer:
            for joint in joints:
                vrep.simxGetJointPosition(client, joint, vrep.simx_opmode_streaming)
            vrep.simxGetObjectPosition(client, ball, camera, vrep.simx_opmode_streaming)
            check(vrep.simxSynchronousTrigger(client))

        def step() -> None:
            for joint, angle in zip(joints, task.pose, strict=True):
                vrep.simxSetJointTargetPosition(client, joint, angle, vrep.simx_opmode_oneshot)
            check(vrep.simxSynchronousTrigger(client))
            for joint in joints:
                check(vrep.simxGetJointPosition(client, joint, mode))
            check(vrep.simxGetObjectPosition(client, ball, camera, mode))

        yield step


_blocking = partial(_legacy, mode=vrep.simx_opmode_blocking)


@contextmanager
def lock_step(task: Task, ports: Sequence[int]) -> Generator[Callable[[], Any]]:
    """The same by ``simx_client.batch``: give a step of all servers at these ports."""
    with ExitStack() as stack:
        ready = [stack.enter_context(_prepared(task, port)) for port in ports]
        servers = batch.Servers([client for client, *_ in ready])

        def read(calls: batch.Calls, place: int) -> list[batch.Answer[Any]]:
            _, joints, camera, ball = ready[place]
            return [
                *[calls.simxGetJointPosition(joint) for joint in joints],
                calls.simxGetObjectPosition(ball, camera),
            ]

        def write(calls: batch.Calls, place: int) -> None:
            for joint, angle in zip(ready[place][1], task.pose, strict=True):
                calls.simxSetJointTargetPosition(joint, angle)

        servers.watch(read)
        yield partial(servers.step, write)
