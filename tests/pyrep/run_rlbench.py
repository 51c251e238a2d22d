"""Run RLBench's tasks over this project: ``python tests/pyrep/run_rlbench.py PATH [TASK ...]``.

PATH is a checkout of RLBench, with PyRep installed or on PYTHONPATH. Each task is loaded, reset several times, and
demonstrated by its waypoints; a line of JSON says how that went, and the last line sums up. Without RLBench's own scene
file the base scene of `base_scene.py` is used. Tasks whose model is missing are not run.
"""

# pyright: reportMissingImports=false, reportUnknownMemberType=false, reportUnknownVariableType=false
# pyright: reportAttributeAccessIssue=false
# pyright: reportUnknownArgumentType=false, reportPrivateUsage=false
from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import simx_client.pyrep
from simx_client.pyrep.worlds import NoSimulation

BASE_SCENE = "task_design.ttt"
MOST_STEPS = 6000
"""Simulation steps of all attempts at a demonstration; RLBench repeats some for ever while an object is missed."""


def with_base_scene(rlbench: Path) -> None:
    """Have launches of RLBench's scene file make the base scene, where the file is missing."""
    import base_scene
    from pyrep import PyRep

    launch = PyRep.launch

    def launch_and_build(self: Any, scene_file: str = "", *arguments: Any, **keywords: Any) -> None:
        if Path(scene_file).name != BASE_SCENE or Path(scene_file).exists():
            launch(self, scene_file, *arguments, **keywords)
            return
        launch(self, "", *arguments, **keywords)
        base_scene.build(self, rlbench / "robot_ttms")

    PyRep.launch = launch_and_build


def tasks_of(rlbench: Path, wanted: list[str]) -> list[str]:
    """Return the tasks that have a class and a model."""
    classes = {path.stem for path in (rlbench / "tasks").glob("[a-z]*.py")}
    models = {path.stem for path in (rlbench / "task_ttms").glob("*.ttm")}
    return wanted or sorted(classes & models)


class Trial:
    """One task in an environment."""

    def __init__(self, environment: Any, name: str, resets: int, *, is_demonstrated: bool) -> None:
        self.outcome: dict[str, Any] = {"task": name, "loads": False, "resets": 0, "demonstrated": False}
        self._environment, self._name, self._resets = environment, name, resets
        self._is_demonstrated = is_demonstrated

    def run(self) -> dict[str, Any]:
        """Load, reset, demonstrate; return what came of it."""
        from rlbench.utils import name_to_task_class

        task: Any = None
        with self._timed("load"):
            task = self._environment.get_task(name_to_task_class(self._name))
            self.outcome["loads"] = True
        if task is None:
            return self.outcome
        for number in range(self._resets):
            with self._timed("reset"):
                if number:
                    task.sample_variation()
                task.reset()
                self.outcome["resets"] += 1
        if not self._is_demonstrated:
            return self.outcome
        left = count(MOST_STEPS, -1)

        def count_step() -> None:
            if next(left) <= 0:
                raise TimeoutError(f"no demonstration within {MOST_STEPS} steps")

        self._environment._scene.register_step_callback(count_step)
        with self._timed("demonstration"):
            demos = task.get_demos(1, live_demos=True, max_attempts=10)
            self.outcome.update(demonstrated=True, steps=len(demos[0]))
        return self.outcome

    def _timed(self, part: str) -> _Timed:
        return _Timed(self.outcome, part)


class _Timed:
    """Notes the seconds of a part, and its error, which does not end the trial."""

    def __init__(self, outcome: dict[str, Any], part: str) -> None:
        self._outcome, self._part = outcome, part
        self._began = time.perf_counter()

    def __enter__(self) -> None:
        pass

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> bool:
        key = f"{self._part}_s"
        seconds = time.perf_counter() - self._began
        self._outcome[key] = round(self._outcome.get(key, 0.0) + seconds, 2)
        if error is not None:
            self._outcome[f"{self._part}_error"] = f"{type(error).__name__}: {error}"[:200]
        return isinstance(error, Exception) and not isinstance(error, NoSimulation)


def outcomes(names: list[str], resets: int, *, are_demonstrated: bool) -> Iterator[dict[str, Any]]:
    """Yield what came of each task."""
    from rlbench.action_modes.action_mode import MoveArmThenGripper
    from rlbench.action_modes.arm_action_modes import JointVelocity
    from rlbench.action_modes.gripper_action_modes import Discrete
    from rlbench.environment import Environment
    from rlbench.observation_config import ObservationConfig

    observed = ObservationConfig()
    observed.set_all(False)
    environment = Environment(
        MoveArmThenGripper(JointVelocity(), Discrete()), obs_config=observed, headless=True
    )
    environment.launch()
    try:
        for name in names:
            yield Trial(environment, name, resets, is_demonstrated=are_demonstrated).run()
    finally:
        environment.shutdown()


def main() -> int:
    """Run the tasks and print what came of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("checkout", metavar="PATH", type=Path)
    parser.add_argument("tasks", metavar="TASK", nargs="*")
    parser.add_argument("--resets", type=int, default=10)
    parser.add_argument("--no-demonstrations", action="store_true", help="load and reset the tasks only")
    options = parser.parse_intermixed_args()
    simx_client.pyrep.activate()
    sys.path.insert(0, str(options.checkout.resolve()))
    rlbench = options.checkout.resolve() / "rlbench"
    with_base_scene(rlbench)
    loaded = reset = demonstrated = tried = 0
    names = tasks_of(rlbench, options.tasks)
    for outcome in outcomes(names, options.resets, are_demonstrated=not options.no_demonstrations):
        print(json.dumps(outcome), flush=True)
        tried += 1
        loaded += outcome["loads"]
        reset += outcome["resets"] == options.resets
        demonstrated += outcome["demonstrated"]
    print(
        f"of {tried} tasks {loaded} load, {reset} are reset {options.resets} times, {demonstrated} are demonstrated"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
