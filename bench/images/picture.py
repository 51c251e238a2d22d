"""One 640x480 image, end to end and in its parts: asking, rendering, the way to the client, the list.

In a stopped simulation equal requests share one image, so a repeated call costs everything but rendering.
A joint that is moved first makes the image a new one.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import ExitStack
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np

import simx_client as vrep
from bench.calls.client import CAMERA, JOINTS, check, handle_of, simulator
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, difference, in_turn, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_client.calls.images import VisionImage
from simx_server.app.server import open_world
from simx_server.handlers import HANDLERS
from simx_server.sensors.opengl.backend import RAYCAST, choose_backend
from simx_server.settings.settings import Settings

from . import rendering

WIDTH, HEIGHT = 640, 480
SIZE = WIDTH * HEIGHT * 3
REQUEST_SIZE = 64

DEPTH_CAMERA = "kinect_depth"
CLIENTS = 10

LIST = "image to a list, all but rendering"
ARRAY = "image to NumPy, all but rendering"
FRESH = "image to NumPy, drawn anew"
BOTH = "image and depth of two cameras in one place to NumPy, drawn anew"
CHANNELS = "the tutorial's loop over the three channels, drawn anew"
RENDER = "rendering alone, in process"
SHARED = f"rendering for {CLIENTS} clients that look through one camera"
ASKING = "asking for an image, physics thread"
QUERY = "bare Zenoh query, as many bytes"
PUBLICATIONS = "bare Zenoh publications, as many bytes"
TCP = "raw TCP, as many bytes"
BUILD = "building the list"
PLAIN = "memoryview.tolist of the same bytes"

FRAME, PLAIN_FRAME = "the tutorial's loop over the three channels", "the same loop over a plain list"
USUAL_FRAME = "the same loop over a plain list by memoryview.tolist"
BARE = "MuJoCo's own renderer, 640 x 480"

BUILD_MOST = 0.85
"""Times `PLAIN`, that building the list may take: 9 ms where that takes 10.6 ms."""

LIST_MOST = 0.95
"""Times `PLAIN`, that an image to a list may take without rendering: 10 ms where that takes 10.6 ms."""

ARRAY_MOST = 4.5
"""Times `QUERY`, that an image to NumPy may take without rendering: 1 ms where that takes 0.22 ms."""

RENDER_MOST = 1.0
"""Times `BARE`."""

FRAME_MOST = 1.1
"""Times `PLAIN_FRAME`, the value that scripts get against a plain list, built the fastest way that Python has."""

ASKING_MOST = 0.07
"""Times `RENDER`: 0.2 ms on the physics thread where an image takes 3 ms."""

SHARED_TARGET = 1.5
"""Times one rendering; ten copies for ten clients are a few tenths of a millisecond."""

RENDER_TIMEOUT_S = 30.0
"""The first image waits for the choice of a graphics driver."""


def measure(effort: Effort) -> Findings:
    """The hand camera of the tutorial's scene, looking at the ball."""

    def take(
        cases: Callable[[ExitStack], dict[str, Callable[[], object]]], stack: ExitStack
    ) -> dict[str, Rounds]:
        return side_by_side("picture", cases(stack), rounds=effort.rounds, calls=effort.count(20))

    taken: dict[str, Rounds] = {}
    for cases in (_transport, partial(_rendering, has_bare=choose_backend().name != RAYCAST), lists):
        taken |= repeated((effort.sets + 1) // 2, partial(take, cases))
    taken |= repeated((effort.sets + 1) // 2, partial(_asking, effort))
    found = _tell(taken)
    rendering.measure_into(found, effort)
    return found


def _transport(stack: ExitStack) -> dict[str, Callable[[], object]]:
    client = stack.enter_context(simulator())
    camera, joints = handle_of(client, CAMERA), [handle_of(client, name) for name in JOINTS]
    pose(client, joints)
    query, publications, tcp = processes.all_baselines(stack)
    depth_camera = handle_of(client, DEPTH_CAMERA)
    request = baselines.request_of(REQUEST_SIZE, SIZE)
    angles = itertools.cycle((0.0, 0.001))

    def image() -> VisionImage:
        return check(vrep.simxGetVisionSensorImage(client, camera, 0, vrep.simx_opmode_blocking))[2]

    def move() -> None:
        vrep.simxSetJointPosition(client, joints[5], next(angles), vrep.simx_opmode_oneshot)

    def fresh() -> Any:
        move()
        return image().array

    def both() -> Any:
        depths = vrep.simxGetVisionSensorDepthBuffer
        return fresh(), check(depths(client, depth_camera, vrep.simx_opmode_blocking))[2].array

    def channels() -> Any:
        move()
        return _channels(image())

    return {
        LIST: lambda: image()[0],
        ARRAY: lambda: image().array,
        FRESH: fresh,
        BOTH: both,
        CHANNELS: channels,
        QUERY: lambda: query.exchange(request),
        PUBLICATIONS: lambda: publications.exchange(request),
        TCP: lambda: tcp.exchange(request),
    }


def _channels(pixels: Any) -> Any:
    return np.dstack([_channel(pixels, first) for first in range(3)])[::-1]


def _channel(pixels: Any, first: int) -> Any:
    """As the tutorial takes it out of the list, number by number."""
    numbers = np.array([pixels[i] for i in range(first, len(pixels), 3)])
    return numbers.reshape(HEIGHT, WIDTH).astype(np.uint8)


def pose(client: int, joints: list[int]) -> None:
    """Let the hand camera see the ball."""
    for handle, degrees in zip(joints, rendering.SEES_THE_BALL, strict=True):
        check(
            vrep.simxSetJointPosition(
                client, handle, degrees * 0.017453292519943295, vrep.simx_opmode_blocking
            )
        )


class _Server:
    """The server's own path from a request to the finished image, on its render thread, in this process."""

    def __init__(self, stack: ExitStack) -> None:
        self._simulation = simulation = open_world(Settings(), stack)
        self._joints = [simulation.simulation.scene.resolve(name) for name in JOINTS]
        self._camera = simulation.simulation.scene.resolve(CAMERA)
        self._angles = itertools.cycle((0.0, 0.001))
        for handle, degrees in zip(self._joints, rendering.SEES_THE_BALL, strict=True):
            self._execute("simxSetJointPosition", handle, degrees * 0.017453292519943295)

    def _execute(self, name: str, *arguments: Any, client: int = 0) -> Any:
        return HANDLERS[name](self._simulation, SimpleNamespace(client=str(client)), list(arguments))

    def move(self) -> None:
        """Make the next image another one."""
        self._execute("simxSetJointPosition", self._joints[5], next(self._angles))

    def ask(self, client: int = 0) -> Future[object]:
        return self._execute("simxGetVisionSensorImage", self._camera, 0, client=client)

    def render(self, clients: int = 1) -> None:
        """A new image for so many clients."""
        self.move()
        for asked in [self.ask(client) for client in range(clients)]:
            asked.result(RENDER_TIMEOUT_S)

    def time_asking(self, calls: int) -> tuple[float, ...]:
        """Seconds after which the physics thread goes on."""
        took: list[float] = []
        for _ in range(calls):
            self.move()
            began = time.perf_counter()
            asked = self.ask()
            took.append(time.perf_counter() - began)
            asked.result(RENDER_TIMEOUT_S)
        return tuple(took)


def _rendering(stack: ExitStack, *, has_bare: bool) -> dict[str, Callable[[], object]]:
    server = _Server(stack)
    cases: dict[str, Callable[[], object]] = {
        RENDER: server.render,
        SHARED: partial(server.render, CLIENTS),
    }
    if has_bare and (bare := stack.enter_context(rendering.bare_renderer_of(rendering.TUTORIAL, CAMERA))):
        cases[BARE] = partial(bare.render, (WIDTH, HEIGHT))
    return cases


def _asking(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    server = _Server(stack)
    server.render()
    return in_turn("picture", {ASKING: lambda: server.time_asking(effort.count(50))}, effort.rounds)


def lists(_stack: ExitStack) -> dict[str, Callable[[], object]]:
    """Return what makes lists of an image's bytes, by name; nothing of it needs a server."""
    data = (bytes(range(256)) * (SIZE // 256 + 1))[:SIZE]
    return {
        BUILD: lambda: VisionImage.from_bytes(data, WIDTH, HEIGHT)[0],
        PLAIN: lambda: memoryview(data).cast("b").tolist(),
        FRAME: lambda: _channels(VisionImage.from_bytes(data, WIDTH, HEIGHT)),
        PLAIN_FRAME: lambda: _channels(_plain(data)),
        USUAL_FRAME: lambda: _channels(memoryview(data).cast("b").tolist()),
    }


_SIGNED = np.array([place - 256 if place > 127 else place for place in range(256)], dtype=object)


def _plain(data: bytes) -> list[int]:
    """Return the numbers as a plain list."""
    numbers: list[int] = _SIGNED.take(np.frombuffer(data, np.uint8)).tolist()
    return numbers


def _tell(taken: dict[str, Rounds]) -> Findings:
    found = Findings("Image, 640 x 480 RGB", topic="Images")
    found.ratios = [
        Ratio(f"{FRAME} / {PLAIN_FRAME}", ratio(taken[FRAME], taken[PLAIN_FRAME]), target=FRAME_MOST),
        Ratio(f"{FRAME} / {USUAL_FRAME}", ratio(taken[FRAME], taken[USUAL_FRAME])),
        Ratio(f"{BUILD} / {PLAIN}", ratio(taken[BUILD], taken[PLAIN]), target=BUILD_MOST),
        Ratio(f"{LIST} / {PLAIN}", ratio(taken[LIST], taken[PLAIN]), target=LIST_MOST),
        Ratio(f"{ARRAY} / {QUERY}", ratio(taken[ARRAY], taken[QUERY]), target=ARRAY_MOST),
        Ratio(f"{ARRAY} / {PUBLICATIONS}", ratio(taken[ARRAY], taken[PUBLICATIONS])),
        Ratio(f"{ASKING} / {RENDER}", taken[ASKING].median / taken[RENDER].median, target=ASKING_MOST),
        Ratio(f"{SHARED} / {RENDER}", ratio(taken[SHARED], taken[RENDER]), target=SHARED_TARGET),
        Ratio(f"{BOTH} / {FRESH}", ratio(taken[BOTH], taken[FRESH])),
    ]
    if BARE in taken:
        found.ratios.append(
            Ratio(f"{RENDER} / {BARE}", ratio(taken[RENDER], taken[BARE]), target=RENDER_MOST)
        )
    found.rows = [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
    found.rows.append(
        Row.of("rendering, as the client sees it", difference(taken[FRESH], taken[ARRAY]), "ms")
    )
    return found
