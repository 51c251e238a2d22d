"""Time RLBench's steps with images: ``python tests/pyrep/step_images.py PATH [--steps N]``.

PATH is a checkout of RLBench, with PyRep installed or on PYTHONPATH. The task reach_target is stepped with five cameras
of 128 x 128. Each line has the calls of a part in one step, and their milliseconds: by the clock, and of the calling
thread's processor. Parts contain each other; the render threads work beside the program.

The last line is the bound: the processors' time for the same images by MuJoCo alone, each place drawn once for its
colours and its depth, without masks.
"""

# pyright: reportMissingImports=false, reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportUnknownArgumentType=false, reportAttributeAccessIssue=false, reportPrivateUsage=false
from __future__ import annotations

import argparse
import copy
import functools
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import simx_client.pyrep

SIZE = [128, 128]
WARM_UP = 20


class Parts:
    """Times functions while `is_on`."""

    def __init__(self) -> None:
        self.is_on = False
        self._spent: dict[str, list[float]] = {}

    def watch(self, owner: Any, name: str, label: str) -> None:
        """Time a function of a module, or a method of a class."""
        function: Callable[..., Any] = getattr(owner, name)
        spent = self._spent[label] = [0.0, 0.0, 0.0]

        @functools.wraps(function)
        def timed(*arguments: Any, **keywords: Any) -> Any:
            if not self.is_on:
                return function(*arguments, **keywords)
            clock, processor = time.perf_counter(), time.thread_time()
            try:
                return function(*arguments, **keywords)
            finally:
                spent[0] += 1
                spent[1] += time.perf_counter() - clock
                spent[2] += time.thread_time() - processor

        setattr(owner, name, timed)

    def print_per(self, steps: int) -> None:
        """Print a line for each part."""
        for label, (calls, clock, processor) in self._spent.items():
            print(
                f"{label:48} {calls / steps:6.1f} {1000 * clock / steps:8.2f} {1000 * processor / steps:8.2f}"
            )


def watch_parts(parts: Parts) -> None:
    """Time the parts of a step."""
    from pyrep import PyRep
    from pyrep.objects.vision_sensor import VisionSensor
    from rlbench.backend.scene import Scene

    from simx_server.sensors.opengl.renderer import OpenGLRenderer

    parts.watch(PyRep, "step", "program: simulation step")
    parts.watch(Scene, "get_observation", "program: observation")
    parts.watch(VisionSensor, "handle_explicitly", "program: handle a sensor")
    parts.watch(VisionSensor, "capture_rgb", "program: read colours or mask")
    parts.watch(VisionSensor, "capture_depth", "program: read depth")
    parts.watch(VisionSensor, "pointcloud_from_depth", "program: point cloud (PyRep)")
    parts.watch(Scene, "_get_misc", "program: poses of cameras and joints (RLBench)")
    parts.watch(OpenGLRenderer, "render", "render thread: image")
    parts.watch(mujoco, "mjv_updateScene", "render thread: mjv_updateScene")
    parts.watch(mujoco, "mjr_render", "render thread: mjr_render")
    parts.watch(mujoco, "mjr_readPixels", "render thread: mjr_readPixels")


class Bound:
    """Draws what the program's cameras see with MuJoCo alone."""

    def __init__(self) -> None:
        self._model: Any = None
        self._seen: dict[int, tuple[Any, ...]] = {}

    def watch(self) -> None:
        """Note the cameras that are drawn, with a copy of a state."""
        from simx_server.sensors.opengl.renderer import OpenGLRenderer

        draw = OpenGLRenderer.render_both

        @functools.wraps(draw)
        def noted(renderer: Any, data: Any, view: Any, *others: Any) -> Any:
            if self._model is not renderer._model:
                self._model, self._seen = renderer._model, {}
            if view.camera_id not in self._seen:
                self._seen[view.camera_id] = view.width, view.height, copy.copy(data)
            return draw(renderer, data, view, *others)

        OpenGLRenderer.render_both = noted

    def seconds(self, rounds: int) -> float:
        """Return the processors' time of a round of all images."""
        from simx_server.sensors.opengl.backend import choose_backend, make_gl_context

        context = make_gl_context(choose_backend().name, 16, 16)
        context.make_current()
        model, free = self._model, mujoco.MjvCamera()
        model.vis.quality.offsamples = model.vis.quality.shadowsize = 0
        drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, drawing)
        scene, option = mujoco.MjvScene(model, 1000), mujoco.MjvOption()
        scene.flags[:] = 0
        scene.flags[mujoco.mjtRndFlag.mjRND_CULL_FACE] = 1
        free.type = mujoco.mjtCamera.mjCAMERA_FIXED
        began = 0.0
        for number in range(-1, rounds):
            began = time.process_time() if number == 0 else began
            for camera, (width, height, data) in self._seen.items():
                free.fixedcamid = camera
                rect = mujoco.MjrRect(0, 0, width, height)
                mujoco.mjv_updateScene(
                    model, data, option, None, free, mujoco.mjtCatBit.mjCAT_ALL.value, scene
                )
                mujoco.mjr_render(rect, scene, drawing)
                colours, depth = np.empty((height, width, 3), np.uint8), np.empty((height, width), np.float32)
                mujoco.mjr_readPixels(colours, depth, rect, drawing)
        took = time.process_time() - began
        drawing.free()
        context.free()
        return took / rounds


def observed(*, has_clouds: bool) -> Any:
    """Return what RLBench observes: everything, in images of `SIZE`."""
    from rlbench.observation_config import ObservationConfig

    config = ObservationConfig()
    config.set_all(True)
    for name in ("left_shoulder", "right_shoulder", "overhead", "wrist", "front"):
        camera = getattr(config, f"{name}_camera")
        camera.image_size = SIZE
        camera.point_cloud = has_clouds
    return config


def run(steps: int, *, with_parts: bool, has_clouds: bool) -> None:
    """Make steps and print what they took."""
    from rlbench.action_modes.action_mode import MoveArmThenGripper
    from rlbench.action_modes.arm_action_modes import JointVelocity
    from rlbench.action_modes.gripper_action_modes import Discrete
    from rlbench.environment import Environment
    from rlbench.tasks import ReachTarget

    parts, bound = Parts(), Bound()
    bound.watch()
    if with_parts:
        watch_parts(parts)
    mode = MoveArmThenGripper(JointVelocity(), Discrete())
    environment = Environment(mode, obs_config=observed(has_clouds=has_clouds), headless=True)
    environment.launch()
    try:
        task = environment.get_task(ReachTarget)
        task.reset()
        random = np.random.default_rng(0)
        action = np.concatenate([random.normal(0.0, 0.1, 7), [1.0]])
        for _ in range(WARM_UP):
            task.step(action)
        parts.is_on = True
        clock, processor, thread = time.perf_counter(), time.process_time(), time.thread_time()
        for number in range(steps):
            # Back and forth, so that the arm stays within sight.
            task.step(action if number // 10 % 2 else -action * [1, 1, 1, 1, 1, 1, 1, -1])
        clock, processor = time.perf_counter() - clock, time.process_time() - processor
        thread = time.thread_time() - thread
        parts.is_on = False
        alone = bound.seconds(steps)
    finally:
        environment.shutdown()
    print(f"{'part':48} {'calls':>6} {'clock':>8} {'thread':>8}")
    parts.print_per(steps)
    each, worked, own = (1000 * seconds / steps for seconds in (clock, processor, thread))
    print(f"a step: {each:.1f} ms by the clock, {1000 / each:.0f} steps a second")
    print(f"processors: {worked:.1f} ms, of which {own:.1f} ms in the program's thread")
    print(f"MuJoCo alone: {1000 * alone:.1f} ms of the processors for the same images")


def main() -> int:
    """Print the times of steps with images."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("checkout", metavar="PATH", type=Path)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--bare", action="store_true", help="do not time parts")
    parser.add_argument("--clouds", action="store_true", help="with PyRep's point clouds of all cameras")
    options = parser.parse_args()
    simx_client.pyrep.activate()
    sys.path.insert(0, str(options.checkout.resolve()))
    from run_rlbench import with_base_scene

    with_base_scene(options.checkout.resolve() / "rlbench")
    run(options.steps, with_parts=not options.bare, has_clouds=options.clouds)
    return 0


if __name__ == "__main__":
    sys.exit(main())
