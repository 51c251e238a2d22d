"""Draws the pictures of the shipped scenes that docs/models.md shows: ``python docs/pictures.py [SCENE ...]``.

Each scene runs a moment first, so that its scripts have begun and loose things lie where they come to rest.
"""

from __future__ import annotations

import os
import sys
from contextlib import ExitStack
from pathlib import Path

os.environ.setdefault("MUJOCO_GL", "egl")

import cv2
import mujoco

from simx_server.app.server import open_world
from simx_server.files.library import list_scenes
from simx_server.handlers.objects.poses import set_object_position
from simx_server.settings.settings import Settings

FOLDER = Path(__file__).with_name("pictures")
WIDTH, HEIGHT = 480, 360
SECONDS = 1.0
SOFTER = 2
"""Drawn so many times as large and averaged, which makes edges smooth."""

VIEWS: dict[str, tuple[tuple[float, float, float], float, float, float]] = {
    "ackermann_line": ((0.0, -4.0, 0.0), 13.0, -60.0, -30.0),
    "bubblerob": ((0.0, 0.0, 0.1), 1.1, 140.0, -25.0),
    "cart_pole": ((0.0, 0.0, 0.8), 3.0, 110.0, -12.0),
    "e_puck": ((0.0, 0.0, 0.02), 0.36, -60.0, -35.0),
    "inverted_pendulum": ((0.0, 0.0, 0.92), 3.3, 120.0, -12.0),
    "lbr_iiwa_7_r800": ((0.0, 0.0, 0.6), 2.8, 140.0, -20.0),
    "line_follower": ((0.0, 0.0, 0.0), 1.5, 90.0, -50.0),
    "line_tracer": ((0.0, 0.0, 0.0), 1.5, 90.0, -50.0),
    "nao": ((0.0, 0.0, 0.28), 1.1, 150.0, -12.0),
    "pioneer_p3dx": ((0.0, 0.0, 0.15), 1.6, 140.0, -25.0),
    "quadricopter": ((0.0, 0.1, 0.5), 1.1, 130.0, -25.0),
    "two_link_arm": ((0.4, 0.0, 0.1), 1.8, 100.0, -45.0),
    "ur10": ((0.0, 0.0, 0.6), 3.0, 140.0, -20.0),
    "ur3": ((0.0, 0.0, 0.35), 1.7, 140.0, -20.0),
    "youbot": ((0.0, 0.0, 0.2), 1.4, -60.0, -20.0),
}
"""Point looked at (m), distance (m), azimuth and elevation (degrees) of MuJoCo's free camera."""

ASIDE = {"quadricopter": ("Quadricopter_target", (-0.1, 0.45, 0.62))}
"""What would hide something, and where it is put at the last moment (m)."""

WITHOUT = {"empty"}
"""Scenes that have nothing to look at."""

OTHERS = ((-0.2, 0.0, 0.4), 2.2, 140.0, -20.0)
"""For scenes without an entry: a table-top arm."""


def draw(scene: str) -> Path:
    """The picture's file."""
    with ExitStack() as stack:
        simulation = open_world(Settings(scene=scene), stack)
        simulation.simulation.start()
        while simulation.simulation.time < SECONDS:
            simulation.step()
        if scene in ASIDE:
            name, place = ASIDE[scene]
            set_object_position(simulation, simulation.simulation.scene.resolve(name), -1, list(place))
            simulation.simulation.refresh()
        camera = mujoco.MjvCamera()
        camera.lookat[:], camera.distance, camera.azimuth, camera.elevation = VIEWS.get(scene, OTHERS)
        model = simulation.simulation.model
        model.vis.global_.offwidth, model.vis.global_.offheight = WIDTH * SOFTER, HEIGHT * SOFTER
        with mujoco.Renderer(model, HEIGHT * SOFTER, WIDTH * SOFTER) as renderer:
            renderer.update_scene(simulation.simulation.data, camera)
            picture = cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2BGR)
        simulation.simulation.stop()
    FOLDER.mkdir(exist_ok=True)
    file = FOLDER / f"{scene}.png"
    cv2.imwrite(str(file), cv2.resize(picture, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA))
    return file


if __name__ == "__main__":
    for name in sys.argv[1:] or sorted(set(list_scenes()) - WITHOUT):
        sys.stdout.write(f"{draw(name)}\n")
