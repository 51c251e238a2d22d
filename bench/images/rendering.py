"""Rendering alone, without a server: shipped scenes and sizes, the parts of one picture, and rays instead of OpenGL.

Parts are told by differences: what a picture of a few pixels costs is the scene's geometry, the rest is its pixels.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, closing
from functools import partial

import mujoco
import numpy as np

from bench.calls.client import CAMERA, JOINTS
from bench.measuring.measure import Effort, Rounds, difference, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_server.app.server import open_world
from simx_server.files.library import find_scene
from simx_server.scene.cameras.image import CameraView, Renderer, fovy_from_perspective_angle
from simx_server.sensors.opengl.backend import RAYCAST, choose_backend
from simx_server.sensors.ray_casting.renderer import RaycastRenderer
from simx_server.settings.settings import Settings
from simx_server.simulation.simulation import Simulation
from simx_server.world.world import World

from .bare import BareRenderer, bare_renderer

TUTORIAL = "ur5_rg2_kinect"
OVERVIEW = "DefaultCamera"
CAMERAS = {
    TUTORIAL: (CAMERA, OVERVIEW),
    "nao": ("NAO_vision1",),
    "e_puck": ("ePuck_camera",),
    "line_tracer": ("LeftSensor",),
    "pioneer_p3dx": (OVERVIEW,),
    "quadricopter": (OVERVIEW,),
}
"""Scenes, and which of their cameras look: their sensors, or else the user's view of the whole."""

LARGE, MEDIUM, SMALL, TINY = (640, 480), (320, 240), (160, 120), (8, 6)

SEES_THE_BALL = (90, -45, 90, 0, -100, 0)
"""The tutorial's pose, degrees: with all joints at zero the hand camera sees nothing, which is cheap to draw."""

BARE_MOST = 1.0
"""Times MuJoCo's own renderer with its defaults."""

SLOWEST = "the slowest camera by rays"
RAYS_MOST = 4.0
"""Times bare `mj_multiRay` with as many rays from the same place."""


def colours(scene: str, camera: str, size: tuple[int, int]) -> str:
    return f"{scene}, {camera}: {size[0]} x {size[1]} colours"


def by_rays(scene: str, camera: str) -> str:
    return f"{scene}, {camera}: {SMALL[0]} x {SMALL[1]} by rays"


def bare_colours(size: tuple[int, int]) -> str:
    return f"{TUTORIAL}, {CAMERA}: {size[0]} x {size[1]} colours by MuJoCo's own renderer"


def bare_rays(scene: str, camera: str) -> str:
    return f"{scene}, {camera}: bare mj_multiRay of {SMALL[0] * SMALL[1]} rays"


BOTH = f"{TUTORIAL}, {CAMERA}: 640 x 480 colours and depth"
DEPTH = f"{TUTORIAL}, {CAMERA}: 640 x 480 depth"
STATE = f"{TUTORIAL}: copy of the state"


def measure_into(found: Findings, effort: Effort) -> None:
    """Add the rows and ratios of every camera."""
    backend = choose_backend().name
    if backend == RAYCAST:
        found.notes.append("There is no OpenGL here: only rays were measured.")
    rays: dict[str, tuple[float, float]] = {}
    for scene in CAMERAS:
        taken = repeated(max(1, effort.sets // 4), partial(_one_set, effort, scene, backend))
        found.rows += [Row.of(what, rounds, "ms") for what, rounds in taken.items()]
        for camera in CAMERAS[scene]:
            cast = taken[by_rays(scene, camera)]
            rays[by_rays(scene, camera)] = cast.median, ratio(cast, taken[bare_rays(scene, camera)])
            if scene == TUTORIAL and camera == CAMERA and backend != RAYCAST:
                _tell_parts(found, taken)
    slowest = max(rays, key=rays.__getitem__)
    found.ratios.append(Ratio(f"{SLOWEST}: {slowest} / bare mj_multiRay", rays[slowest][1], target=RAYS_MOST))


def _tell_parts(found: Findings, taken: dict[str, Rounds]) -> None:
    large, geometry = (taken[colours(TUTORIAL, CAMERA, size)] for size in (LARGE, TINY))
    for size in (LARGE, MEDIUM):
        if (bare := taken.get(bare_colours(size))) is not None:
            what = colours(TUTORIAL, CAMERA, size)
            found.ratios.append(
                Ratio(f"{what} / MuJoCo's own renderer", ratio(taken[what], bare), target=BARE_MOST)
            )
    found.rows += [
        Row.of(
            f"{TUTORIAL}, {CAMERA}: pixels, their texture and reading them", difference(large, geometry), "ms"
        ),
        Row.of(f"{TUTORIAL}, {CAMERA}: depth beside colours", difference(taken[BOTH], large), "ms"),
    ]


def view_of(world: World, camera: str, size: tuple[int, int]) -> CameraView:
    """A camera's view in another size."""
    simulation = world.simulation
    handle = simulation.scene.resolve(camera)
    settings = world.vision.settings(handle)
    return CameraView(
        camera_id=simulation.scene.get(handle).id,
        width=size[0],
        height=size[1],
        fovy_deg=fovy_from_perspective_angle(settings.angle, *size),
        near=settings.near,
        far=settings.far,
        orthographic_size=settings.orthographic_size,
    )


def look_at_the_ball(simulation: Simulation) -> None:
    """The tutorial's arm in its pose."""
    for joint, degrees in zip(JOINTS, SEES_THE_BALL, strict=True):
        simulation.data.joint(joint).qpos[0] = degrees * 0.017453292519943295
    mujoco.mj_forward(simulation.model, simulation.data)


def bare_renderer_of(scene: str, camera: str) -> AbstractContextManager[BareRenderer | None]:
    """Return MuJoCo's own renderer of a shipped scene, the tutorial's arm in its pose."""
    pose = zip(JOINTS, SEES_THE_BALL, strict=True) if scene == TUTORIAL else ()
    angles = {joint: degrees * 0.017453292519943295 for joint, degrees in pose}
    return bare_renderer(str(find_scene(scene)), camera, angles)


def _multi_ray(model: mujoco.MjModel, data: mujoco.MjData, view: CameraView) -> Callable[[], object]:
    """Return a cast of a ray for each pixel, and nothing else."""
    count = view.width * view.height
    half = math.tan(math.radians(view.fovy_deg) / 2)
    x, y = np.meshgrid(
        np.linspace(-half * view.width / view.height, half * view.width / view.height, view.width),
        np.linspace(-half, half, view.height),
    )
    local = np.stack([x.ravel(), y.ravel(), np.full(count, -1.0)], axis=1)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    rays = np.ascontiguousarray(local @ data.cam_xmat[view.camera_id].reshape(3, 3).T).ravel()
    place, geoms, distances = data.cam_xpos[view.camera_id].copy(), np.zeros(count, np.int32), np.zeros(count)

    def cast() -> None:
        mujoco.mj_multiRay(
            model, data, place, rays, None, 1, -1, geoms, distances, None, count, mujoco.mjMAXVAL
        )

    return cast


def _one_set(effort: Effort, scene: str, backend: str, stack: ExitStack) -> dict[str, Rounds]:
    simulation = open_world(Settings(scene=scene), stack)
    model, data = simulation.simulation.model, simulation.simulation.data
    if scene == TUTORIAL:
        look_at_the_ball(simulation.simulation)
    mujoco.mj_forward(model, data)
    cases: dict[str, Callable[[], object]] = {}
    rays = stack.enter_context(closing(RaycastRenderer(model)))

    def add(what: str, renderer: Renderer, view: CameraView, rgb: bool = True, depth: bool = False) -> None:
        cases[what] = partial(renderer.render, data, view, rgb, depth)

    for camera in CAMERAS[scene]:
        if backend != RAYCAST:
            from simx_server.sensors.opengl.renderer import OpenGLRenderer

            drawn = stack.enter_context(closing(OpenGLRenderer(model, backend)))
            for size in (LARGE, MEDIUM, SMALL, TINY):
                add(colours(scene, camera, size), drawn, view_of(simulation, camera, size))
            if (scene, camera) == (TUTORIAL, CAMERA):
                large = view_of(simulation, camera, LARGE)
                add(BOTH, drawn, large, depth=True)
                add(DEPTH, drawn, large, rgb=False, depth=True)
        small = view_of(simulation, camera, SMALL)
        add(by_rays(scene, camera), rays, small)
        cases[bare_rays(scene, camera)] = _multi_ray(model, data, small)
    if (
        scene == TUTORIAL
        and backend != RAYCAST
        and (bare := stack.enter_context(bare_renderer_of(scene, CAMERA)))
    ):
        for size in (LARGE, MEDIUM):
            cases[bare_colours(size)] = partial(bare.render, size)
    if scene == TUTORIAL:
        copied = mujoco.MjData(model)
        cases[STATE] = lambda: mujoco.mj_copyData(copied, model, data)
    return side_by_side(f"rendering {scene}", cases, rounds=effort.rounds, calls=effort.count(30))
