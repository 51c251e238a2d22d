"""Render the first vision sensor of a scene, turned to its objects, and print JSON. Runs as a child process."""

from __future__ import annotations

import json
import math
import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from simx_server.sensors.opengl.mujoco_import import import_mujoco

if TYPE_CHECKING:
    from simx_server.world.world import World

TIMEOUT = 100.0
"""Time-out in seconds for one image."""


def main(arguments: list[str]) -> int:
    """Print the result; return exit status 1 with a reason on stderr when the image cannot be made."""
    import_mujoco()
    from simx_server.errors import CommandError
    from simx_server.scene.cameras.image import RenderError

    try:
        found = _look(arguments[0] if arguments else None)
    except (CommandError, RenderError, TimeoutError) as error:
        sys.stderr.write(f"{error or type(error).__name__}\n")
        return 1
    sys.stdout.write(json.dumps(found) + "\n")
    return 0


def _look(scene: str | None) -> dict[str, Any]:
    import numpy as np

    from simx_server.app.server import open_world
    from simx_server.scene.formats.jacobian import solver_problem
    from simx_server.scene.objects import ObjectKind
    from simx_server.settings.settings import Settings

    with ExitStack() as stack:
        world = open_world(Settings(scene=scene), stack)
        simulation = world.simulation
        solver = solver_problem(simulation.model)
        sensors = simulation.scene.of_kind(ObjectKind.VISION_SENSOR)
        if not sensors:
            return {"scene": simulation.scene.name, "sensor": None, "solver": solver}
        handle = sensors[0]
        _look_at_all(world, handle)
        (width, height), pixels = world.vision.image(handle, as_grey=False).result(TIMEOUT)
        _, depths = world.vision.depth(handle).result(TIMEOUT)
        simulation.start()
        world.step()
        began = time.perf_counter()
        world.vision.image(handle, as_grey=False).result(TIMEOUT)
        took = time.perf_counter() - began
        backend = world.rendering.backend
        colours = np.frombuffer(pixels, np.uint8).reshape(-1, 3)
        return {
            "scene": simulation.scene.name,
            "sensor": simulation.scene.get(handle).name,
            "backend": backend.name if backend is not None else "",
            "width": width,
            "height": height,
            "colours": len(np.unique(colours, axis=0)),
            "darkest": int(colours.max(axis=1).min()),
            "brightest": int(colours.max(axis=1).max()),
            "covered": float((np.frombuffer(depths, "<f4") < 1).mean()),
            "milliseconds": 1000 * took,
            "solver": solver,
        }


def _look_at_all(world: World, sensor: int) -> None:
    """Move a vision sensor so that it sees most of the scene: in its original pose it may see only the sky."""
    import mujoco
    import numpy as np

    simulation = world.simulation
    model, data = simulation.model, simulation.data
    camera = simulation.scene.get(sensor).id
    places = data.xpos[1:]
    middle = np.median(places, axis=0)
    spread = float(np.median(np.linalg.norm(places - middle, axis=1)))
    distance = min(max(3 * spread, 1.0), 0.6 * world.vision.settings(sensor).far)
    backwards = np.array((1.0, -1.0, 1.0)) / math.sqrt(3)
    right = np.array((1.0, 1.0, 0.0)) / math.sqrt(2)
    # A camera looks along -z, with +x to the right.
    axes = np.column_stack((right, np.cross(backwards, right), backwards))
    body = model.cam_bodyid[camera]
    turn = data.xmat[body].reshape(3, 3).T
    model.cam_pos[camera] = turn @ (middle + distance * backwards - data.xpos[body])
    mujoco.mju_mat2Quat(model.cam_quat[camera], (turn @ axes).ravel())
    mujoco.mj_forward(model, data)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
