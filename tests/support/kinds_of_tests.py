"""What a test needs of the machine, as markers: real processes, OpenGL, Chromium.

Imports show which files start processes. The files that render are listed: those in which an OpenGL context was made
when all tests ran, also by a server that a test started.
"""

from __future__ import annotations

import ast
import functools
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
HELPERS = tuple(TESTS / "support" / folder for folder in ("", "worlds", "vrep_files"))
BROWSER = ("test_classroom_browser", "test_view_browser")
GL = (
    "test_bench_smoke", "test_detect_example", "test_determinism", "test_doctor", "test_faults_stops",
    "test_files", "test_filming", "test_first_picture", "test_fleet", "test_gl_backend", "test_gym_environments",
    "test_gym_page", "test_gym_quantities", "test_gym_stable_baselines3", "test_gym_tasks", "test_gym_vectors",
    "test_bench_smoke", "test_classroom", "test_classroom_browser",
    "test_detect_example", "test_determinism", "test_doctor", "test_faults_stops",
    "test_files", "test_filming", "test_first_picture", "test_fleet", "test_gl_backend",
    "test_hostile_peers", "test_idioms_images", "test_keyboard_example", "test_legacy_scripts", "test_light",
    "test_models_line_tracer", "test_models_scanner", "test_models_small", "test_models_vehicles",
    "test_original_commands", "test_original_hostile", "test_original_library", "test_over_zenoh", "test_pace",
    "test_parameter_functions", "test_readers_change_nothing", "test_readme",
    "test_render_thread", "test_rendering", "test_replay_pictures", "test_ros2_images", "test_ros2_sdk",
    "test_scripts_vision",
    "test_sensor_functions", "test_sensors_handles", "test_soak", "test_state_log",
    "test_streaming_instants", "test_surprises", "test_tutorial_look", "test_tutorial_over_the_api",
    "test_upgrade", "test_view_browser", "test_view_cameras", "test_view_process", "test_wheels",
    "test_zmq_example_images",
)  # fmt: skip
STARTS_BY_LIBRARY = (
    "test_bench_smoke", "test_cli_vrep", "test_detect_example", "test_fleets_on_ray", "test_gym_page",
    "test_hostile_peers", "test_reach_example", "test_rehearsal", "test_scripts_python", "test_scripts_twins",
)  # fmt: skip
"""Files that start processes by functions of the packages, of the examples or of the benchmarks."""

_PROCESSES = {"server", "spawn", "running"}
"""Functions of tests/processes.py that start processes; the others are for all tests."""


def add_markers(item: pytest.Item) -> None:
    """Add the markers ``system``, ``gl`` and ``browser`` as they apply."""
    name = item.path.stem
    if name in STARTS_BY_LIBRARY or _starts_processes(item.path):
        item.add_marker(pytest.mark.system)
    if name in BROWSER:
        item.add_marker(pytest.mark.browser)
    parameters = getattr(item, "callspec", None)
    casts_rays = parameters is not None and parameters.params.get("make_renderer") == "raycast"
    if name in GL and not casts_rays:
        item.add_marker(pytest.mark.gl)


@functools.cache
def _starts_processes(path: Path) -> bool:
    """Whether a file imports `subprocess`, or another file of the tests which does."""
    waiting, seen = [path], {path}
    while waiting:
        for module, name in _imports(waiting.pop()):
            if module.partition(".")[0] in ("subprocess", "multiprocessing"):
                return True
            if module == "processes":
                if name in _PROCESSES:
                    return True
                continue
            helpers = set(_helpers(module, {path.parent, *HELPERS})) - seen
            waiting.extend(helpers)
            seen |= helpers
    return False


@functools.cache
def _imports(path: Path) -> tuple[tuple[str, str], ...]:
    """The module of every absolute import, and the name that is taken from it."""
    found: list[tuple[str, str]] = []
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            found.extend((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.extend((node.module, alias.name) for alias in node.names)
    return tuple(found)


def _helpers(module: str, folders: set[Path]) -> list[Path]:
    """The file of the tests that an import means, if it is one."""
    return [file for folder in folders if (file := folder / f"{module}.py").is_file()]
