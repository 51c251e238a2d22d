"""How cost grows with a picture's size: rendering, the way to a list and to NumPy, beside as many bare bytes."""

from __future__ import annotations

import itertools
from contextlib import ExitStack, closing
from functools import partial
from typing import Any

import simx_client as vrep
from bench.calls.client import CAMERA, JOINTS, check, handle_of, simulator
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, difference, repeated, side_by_side
from bench.measuring.report import Findings, Grid, Panel, Plot
from simx_client.calls.images import VisionImage
from simx_server.app.server import open_world
from simx_server.scene.cameras.image import Renderer
from simx_server.sensors.opengl.backend import RAYCAST, choose_backend
from simx_server.sensors.ray_casting.renderer import RaycastRenderer
from simx_server.settings.settings import Settings

from . import rendering
from .picture import REQUEST_SIZE, pose

SIZES = ((80, 60), (160, 120), (320, 240), (640, 480), (1280, 960))

RENDER = "rendering, in process"
LIST = "to a list"
ARRAY = "to NumPy"
FRESH = "drawn anew, to NumPy"
QUERY = "bare Zenoh query, as many bytes"
CASES = (RENDER, FRESH, LIST, ARRAY, QUERY)


def measure(effort: Effort) -> Findings:
    """The hand camera of the tutorial's scene, looking at the ball, in every size."""
    taken = repeated(max(1, effort.sets // 3), partial(_one_set, effort))
    found = Findings("Cost against image size", topic="Images")
    found.grids.append(
        Grid(
            ("pixels", *(f"{case}, ms" for case in CASES)),
            [
                (f"{width} x {height}", [taken[_name(case, (width, height))].median * 1e3 for case in CASES])
                for width, height in SIZES
            ],
        )
    )

    def curve(case: str) -> list[tuple[float, float]]:
        return [(size[0], taken[_name(case, size)].median * 1e3) for size in SIZES]

    seen = {
        f"{RENDER.partition(',')[0]}, as a client sees it": [
            (
                size[0],
                max(1e-3, difference(taken[_name(FRESH, size)], taken[_name(ARRAY, size)]).median * 1e3),
            )
            for size in SIZES
        ]
    }
    found.plots.append(
        Plot(
            "sizes",
            [
                Panel(
                    "a picture that is there, ms",
                    "width in pixels (4 : 3)",
                    {LIST: curve(LIST), ARRAY: curve(ARRAY)},
                    {QUERY: curve(QUERY)},
                    is_log=True,
                ),
                Panel(
                    "a picture that is drawn anew, ms",
                    "width in pixels (4 : 3)",
                    {FRESH: curve(FRESH), **seen},
                    {RENDER: curve(RENDER)},
                    is_log=True,
                ),
            ],
        )
    )
    found.notes.append(
        f"'{LIST}' and '{ARRAY}' are end to end for a picture that another client has asked for already: "
        "everything but rendering."
    )
    return found


def _name(case: str, size: tuple[int, int]) -> str:
    return f"{case}, {size[0]} x {size[1]}"


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    client = stack.enter_context(simulator())
    camera, joints = handle_of(client, CAMERA), [handle_of(client, name) for name in JOINTS]
    pose(client, joints)
    far = stack.enter_context(processes.baseline(baselines.QUERY))
    query = stack.enter_context(closing(baselines.Query(far.port)))
    render = _renderer(stack)
    angles = itertools.cycle((0.0, 0.001))

    def image() -> VisionImage:
        return check(vrep.simxGetVisionSensorImage(client, camera, 0, vrep.simx_opmode_blocking))[2]

    def fresh() -> Any:
        vrep.simxSetJointPosition(client, joints[5], next(angles), vrep.simx_opmode_oneshot)
        return image().array

    taken: dict[str, Rounds] = {}
    for size in SIZES:
        _resize(client, camera, size)
        request = baselines.request_of(REQUEST_SIZE, 3 * size[0] * size[1])
        cases = {
            RENDER: partial(render, size),
            FRESH: fresh,
            LIST: lambda: image()[0],
            ARRAY: lambda: image().array,
            QUERY: partial(query.exchange, request),
        }
        named = {_name(case, size): call for case, call in cases.items()}
        taken |= side_by_side("sizes", named, rounds=effort.rounds, calls=effort.count(20))
    return taken


def _resize(client: int, camera: int, size: tuple[int, int]) -> None:
    sides = (vrep.sim_visionintparam_resolution_x, vrep.sim_visionintparam_resolution_y)
    for parameter, pixels in zip(sides, size, strict=True):
        check(vrep.simxSetObjectIntParameter(client, camera, parameter, pixels, vrep.simx_opmode_blocking))


def _renderer(stack: ExitStack) -> Any:
    """Draws one picture of a size, in this process."""
    simulation = open_world(Settings(), stack)
    rendering.look_at_the_ball(simulation.simulation)
    backend = choose_backend().name
    if backend == RAYCAST:
        renderer: Renderer = RaycastRenderer(simulation.simulation.model)
    else:
        from simx_server.sensors.opengl.renderer import OpenGLRenderer

        renderer = OpenGLRenderer(simulation.simulation.model, backend)
    drawn = stack.enter_context(closing(renderer))
    views = {size: rendering.view_of(simulation, CAMERA, size) for size in SIZES}
    return lambda size: drawn.render(simulation.simulation.data, views[size], True, False)
