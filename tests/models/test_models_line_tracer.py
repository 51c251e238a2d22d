"""The LineTracer follows its track by what its eyes detect, in images by OpenGL and by rays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from model_checks import position_of
from real_world import RealWorld, handle_of, render_with, start_stepped, step

import simx_client as vrep
from simx_server.sensors.opengl.backend import RAYCAST, Backend
from simx_server.sensors.rendering.render_thread import RenderThread

pytestmark = [pytest.mark.slow, pytest.mark.gl]

World = tuple[RealWorld, int]
Open = Callable[..., World]
MIDDLE = (0.084, 0.7)
"""Of the track."""

WAY = 0.25
"""Of a round: all quarters have the same shape."""


@pytest.fixture
def world() -> Iterator[Open]:
    """Opens a scene: the world, and a client of it. `back_end`: what draws; None: what the server chooses."""
    with ExitStack() as opened:

        def open_scene(scene: str, back_end: str | None = None) -> World:
            one = RealWorld(scene)
            opened.callback(one.close)
            if back_end is not None:
                chosen = Backend(back_end, "the test wants it")
                render_with(one, RenderThread(lambda: chosen))
                opened.callback(one.parts.rendering.close)
            return one, one.client()

        yield open_scene


@pytest.mark.parametrize("back_end", [None, RAYCAST])
def test_line_tracer_follows_its_track(
    world: Open, back_end: str | None, record_property: Callable[[str, str], None]
) -> None:
    _, clientID = world("line_tracer", back_end)
    robot = handle_of(clientID, "LineTracer")
    left, right = handle_of(clientID, "DynamicLeftJoint"), handle_of(clientID, "DynamicRightJoint")
    eyes = [handle_of(clientID, name) for name in ("LeftSensor", "MiddleSensor", "RightSensor")]
    for eye in eyes:
        vrep.simxReadVisionSensor(clientID, eye, vrep.simx_opmode_streaming)
    start_stepped(clientID)
    step(clientID, 0.05)
    begin = position_of(clientID, robot)
    bearing, turned = math.atan2(begin[1] - MIDDLE[1], begin[0] - MIDDLE[0]), 0.0
    passes, on_line, farthest = 0, 0, 0.0
    for _ in range(300):
        bright = [vrep.simxReadVisionSensor(clientID, eye, vrep.simx_opmode_buffer)[1] for eye in eyes]
        velocity = 0.12 / 0.027
        passes += 1
        on_line += not all(bright)
        vrep.simxPauseCommunication(clientID, True)
        vrep.simxSetJointTargetVelocity(
            clientID, left, velocity * (1.0 if bright[0] else 0.3), vrep.simx_opmode_oneshot
        )
        vrep.simxSetJointTargetVelocity(
            clientID, right, velocity * (1.0 if bright[2] else 0.3), vrep.simx_opmode_oneshot
        )
        vrep.simxPauseCommunication(clientID, False)
        step(clientID, 0.05)
        x, y, _ = position_of(clientID, robot)
        before, bearing = bearing, math.atan2(y - MIDDLE[1], x - MIDDLE[0])
        turned += math.remainder(bearing - before, math.tau)
        track = 0.62 + 0.08 * math.cos(4 * bearing)
        farthest = max(farthest, abs(math.hypot(x - MIDDLE[0], y - MIDDLE[1]) - track))
        if abs(turned) >= WAY * math.tau:
            break
    else:
        pytest.fail(f"it did not come round: {turned:.1f} radians, now at {x:.2f}, {y:.2f}")
    record_property(
        "figures",
        f"line tracer, {back_end or 'the chosen renderer'}: {WAY} of the round in {passes * 0.05:.0f} s, "
        f"{farthest * 1000:.0f} mm off at most, line seen in {100 * on_line / passes:.0f} % of the passes",
    )
    assert farthest < 0.06
