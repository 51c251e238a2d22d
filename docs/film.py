"""Makes the film at the top of the README: ``python docs/film.py``.

The tutorial's robot moves by legacy calls; the image of its hand camera is shown in the corner.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

import simx_client as vrep
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_server.app.server import open_world
from simx_server.gateways.embedded.transport import EmbeddedTransport
from simx_server.gateways.embedded.turns import Turns
from simx_server.handlers import HANDLERS
from simx_server.service.clock import Pacer
from simx_server.service.server_loop import ServerLoop
from simx_server.settings.settings import Settings
from simx_server.simulation.simulation import Simulation

FILE = Path(__file__).with_name("pictures") / "tutorial.webp"
WIDTH, HEIGHT = 640, 400
INSET = 200, 150
MARGIN = 8
"""Pixels."""

STEPS_PER_FRAME = 2
MILLISECONDS_PER_FRAME = 80
QUALITY = 70

LOOK_AT, DISTANCE, AZIMUTH, ELEVATION = (-0.12, 0.08, 0.42), 1.9, 155.0, -16.0
"""MuJoCo's free camera: metres and degrees."""

Image = NDArray[np.uint8]
"""(height, width, 3) BGR, the top row first."""

WAIT, SEND = vrep.simx_opmode_blocking, vrep.simx_opmode_oneshot
REST, VIEW = (0, 0, 0, 0, 0, 0), (90, -45, 90, 0, -100, 0)
LOOK_AROUND = (115, -50, 95, 10, -80, 40)
"""Joint angles, degrees."""

SCENARIO = (
    (VIEW, None, 50),
    (VIEW, "rg2Close", 16),
    (LOOK_AROUND, "rg2Open", 24),
    (VIEW, None, 24),
    (REST, None, 46),
)
"""Targets, function of the gripper's script, simulation steps."""


def frames() -> Iterator[Image]:
    """Run the scenario by legacy calls, in stepped mode."""
    with ExitStack() as stack:
        simulation = open_world(Settings(scene="ur5_rg2_kinect_ball"), stack)
        loop = ServerLoop(simulation, HANDLERS, Pacer(math.inf))
        turns = Turns(loop)
        connection = Connection(lambda: EmbeddedTransport(loop, turns, "film", "film", 0), where="film")
        client = CLIENTS.add(connection)
        connection.connect(1.0)
        stack.callback(vrep.simxFinish, client)
        joints = [vrep.simxGetObjectHandle(client, f"UR5_joint{i}", WAIT)[1] for i in range(1, 7)]
        camera = vrep.simxGetObjectHandle(client, "kinect_rgb", WAIT)[1]
        vrep.simxSynchronous(client, True)
        vrep.simxStartSimulation(client, WAIT)
        for targets, function, steps in SCENARIO:
            for joint, degrees in zip(joints, targets, strict=True):
                vrep.simxSetJointTargetPosition(client, joint, math.radians(degrees), SEND)
            if function:
                child = vrep.sim_scripttype_childscript
                vrep.simxCallScriptFunction(client, "RG2", child, function, [], [], [], bytearray(), WAIT)
            for step in range(steps):
                vrep.simxSynchronousTrigger(client)
                if step % STEPS_PER_FRAME == 0:
                    yield inset(overview(simulation.simulation), seen(client, camera))


def overview(simulation: Simulation) -> Image:
    """What stands before a person; drawn twice as large and averaged, which makes edges smooth."""
    view = mujoco.MjvCamera()
    view.lookat[:], view.distance, view.azimuth, view.elevation = LOOK_AT, DISTANCE, AZIMUTH, ELEVATION
    offscreen = simulation.model.vis.global_
    offscreen.offwidth, offscreen.offheight = 2 * WIDTH, 2 * HEIGHT
    with mujoco.Renderer(simulation.model, 2 * HEIGHT, 2 * WIDTH) as renderer:
        renderer.update_scene(simulation.data, view)
        drawn = cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2BGR)
    return cv2.resize(drawn, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)


def seen(client: int, camera: int) -> Image:
    """The hand camera's image."""
    _, (width, height), image = vrep.simxGetVisionSensorImage(client, camera, 0, WAIT)
    rgb = np.flipud(np.array(image, dtype=np.uint8).reshape(height, width, 3))
    return cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)


def inset(large: Image, small: Image) -> Image:
    """Put the small image into the upper left corner, with a white border."""
    scaled = cv2.resize(small, INSET, interpolation=cv2.INTER_AREA)
    bordered = cv2.copyMakeBorder(scaled, *[2] * 4, cv2.BORDER_CONSTANT, value=(255, 255, 255))
    height, width = bordered.shape[:2]
    large[MARGIN : MARGIN + height, MARGIN : MARGIN + width] = bordered
    return large


def main() -> None:
    """Write the film."""
    film = cv2.Animation()
    film.frames = list(frames())
    film.durations = [MILLISECONDS_PER_FRAME] * len(film.frames)
    cv2.imwriteanimation(str(FILE), film, [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    print(f"{FILE}: {len(film.frames)} frames, {FILE.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
