"""From a file to a scene: MJCF or URDF, prepared through MjSpec so that V-REP's names and joint modes have a home.

Preparation adds, never removes: names for what has none, and a velocity actuator (gain 0: no force) for every hinge and
slide joint without a plain actuator, so that a motor can be switched on later without compiling again.
"""

from __future__ import annotations

from pathlib import Path

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.objects import Scene


class SceneError(CommandError):
    """A scene file that cannot be loaded; the text names the element and what is valid."""


def load_scene(path: str | Path) -> tuple[Scene, mujoco.MjModel]:
    """Read, prepare and compile a file. Raises SceneError."""
    raise NotImplementedError


def empty_scene() -> tuple[Scene, mujoco.MjModel]:
    """The scene that is left after closing: gravity, no objects."""
    raise NotImplementedError
