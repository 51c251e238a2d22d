"""One 640x480 picture, end to end and in its parts: rendering, the way to the client, the list.

In a stopped simulation equal requests share one picture, so a repeated call costs everything but rendering.
A joint that is moved first makes the picture a new one.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from contextlib import ExitStack, closing
from functools import partial
from typing import Any

import simx_client as vrep
from simx_client.values import VisionImage
from simx_server.handlers import HANDLERS
from simx_server.server import build_simulation
from simx_server.settings import Settings

from . import baselines, processes
from .client import CAMERA, JOINTS, check, handle_of, simulator
from .measure import Effort, Rounds, difference, ratio, repeated, side_by_side
from .report import Findings, Ratio, Row

WIDTH, HEIGHT = 640, 480
SIZE = WIDTH * HEIGHT * 3
REQUEST_SIZE = 64

SEES_THE_BALL = (90, -45, 90, 0, -100, 0)
"""The tutorial's pose, degrees: with all joints at zero the camera sees nothing, which is cheap to draw."""

LIST = "picture to a list, all but rendering"
ARRAY = "picture to NumPy, all but rendering"
FRESH = "picture to NumPy, drawn anew"
RENDER = "rendering alone, in process"
QUERY = "bare Zenoh query, as many bytes"
PUBLICATIONS = "bare Zenoh publications, as many bytes"
TCP = "raw TCP, as many bytes"
BUILD = "building the list"
PLAIN = "memoryview.tolist of the same bytes"

TARGETS_MS = {BUILD: 9.0, LIST: 12.0, ARRAY: 2.0, RENDER: 12.0}
RENDER_TIMEOUT_S = 30.0
"""The first picture waits for the choice of a graphics driver."""


def measure(effort: Effort) -> Findings:
    """The hand camera of the tutorial's scene, looking at the ball."""

    def take(
        cases: Callable[[ExitStack], dict[str, Callable[[], object]]], stack: ExitStack
    ) -> dict[str, Rounds]:
        return side_by_side("picture", cases(stack), rounds=effort.rounds, calls=effort.count(20))

    taken: dict[str, Rounds] = {}
    for cases in (_transport, _rendering, _lists):
        taken |= repeated(effort.sets, partial(take, cases))
    return _tell(taken)


def _transport(stack: ExitStack) -> dict[str, Callable[[], object]]:
    client = stack.enter_context(simulator())
    camera, joints = handle_of(client, CAMERA), [handle_of(client, name) for name in JOINTS]
    _pose(client, joints)
    query, publications, tcp = (
        stack.enter_context(closing(near(stack.enter_context(processes.baseline(far)).port)))
        for near, far in (
            (baselines.Query, baselines.QUERY),
            (baselines.Publications, baselines.PUBLICATIONS),
            (baselines.Tcp, baselines.TCP),
        )
    )
    request = baselines.request_of(REQUEST_SIZE, SIZE)
    angles = itertools.cycle((0.0, 0.001))

    def image() -> VisionImage:
        return check(vrep.simxGetVisionSensorImage(client, camera, 0, vrep.simx_opmode_blocking))[2]

    def fresh() -> Any:
        vrep.simxSetJointPosition(client, joints[5], next(angles), vrep.simx_opmode_oneshot)
        return image().array

    return {
        LIST: lambda: image()[0],
        ARRAY: lambda: image().array,
        FRESH: fresh,
        QUERY: lambda: query.exchange(request),
        PUBLICATIONS: lambda: publications.exchange(request),
        TCP: lambda: tcp.exchange(request),
    }


def _pose(client: int, joints: list[int]) -> None:
    for handle, degrees in zip(joints, SEES_THE_BALL, strict=True):
        check(
            vrep.simxSetJointPosition(
                client, handle, degrees * 0.017453292519943295, vrep.simx_opmode_blocking
            )
        )


def _rendering(stack: ExitStack) -> dict[str, Callable[[], object]]:
    """The server's own path from a request to the finished picture, on its render thread, in this process."""
    simulation = build_simulation(Settings(), stack)
    joints = [simulation.scene.resolve(name) for name in JOINTS]
    camera = simulation.scene.resolve(CAMERA)
    angles = itertools.cycle((0.0, 0.001))

    def execute(name: str, *arguments: Any) -> Any:
        return HANDLERS[name](simulation, None, list(arguments))

    for handle, degrees in zip(joints, SEES_THE_BALL, strict=True):
        execute("simxSetJointPosition", handle, degrees * 0.017453292519943295)

    def render() -> object:
        execute("simxSetJointPosition", joints[5], next(angles))
        return execute("simxGetVisionSensorImage", camera, 0).result(RENDER_TIMEOUT_S)

    return {RENDER: render}


def _lists(stack: ExitStack) -> dict[str, Callable[[], object]]:
    data = (bytes(range(256)) * (SIZE // 256 + 1))[:SIZE]
    return {
        BUILD: lambda: VisionImage.from_bytes(data, WIDTH, HEIGHT)[0],
        PLAIN: lambda: memoryview(data).cast("b").tolist(),
    }


def _tell(taken: dict[str, Rounds]) -> Findings:
    found = Findings("Picture, 640 x 480 RGB")
    found.ratios = [
        *(Ratio(f"{what}", taken[what].median * 1000, "ms", target) for what, target in TARGETS_MS.items()),
        Ratio(f"{ARRAY} / {QUERY}", ratio(taken[ARRAY], taken[QUERY])),
        Ratio(f"{ARRAY} / {PUBLICATIONS}", ratio(taken[ARRAY], taken[PUBLICATIONS])),
        Ratio(f"{BUILD} / {PLAIN}", ratio(taken[BUILD], taken[PLAIN])),
    ]
    found.rows = [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
    found.rows.append(
        Row.of("rendering, as the client sees it", difference(taken[FRESH], taken[ARRAY]), "ms")
    )
    return found
