"""A base scene for RLBench, for who has its task models and not its own scene file: the names that RLBench asks for.

The places and sizes are our own, near those that papers on RLBench state: a Panda behind a table of 0.75 m, a workspace
of 0.65 m x 0.91 m in front of it, four cameras around and one at the wrist.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

import math
from pathlib import Path
from typing import Any

TABLE = 0.752
"""Height of the table's top in m."""

ROBOT = (-0.308, 0.0, 0.8225)
WORKSPACE = (0.25, 0.0, TABLE)
WORKSPACE_SIZE = (0.65, 0.91)

CAMERAS = {
    "cam_over_shoulder_left": (0.17, 0.75, 1.95),
    "cam_over_shoulder_right": (0.17, -0.75, 1.95),
    "cam_overhead": (-0.15, 0.0, 2.1),
    "cam_front": (1.45, 0.0, 1.6),
}
"""Places in the world; each camera looks at the middle of the workspace."""

CINEMATIC = (1.5, 1.0, 1.9)
_WATCHED = (WORKSPACE[0], WORKSPACE[1], TABLE + 0.1)

ROOM = 3.0
"""Half the width of the room in m."""


def build(program: Any, robots: Path) -> None:
    """Make the scene in a launched simulation.

    Args:
        program: a ``pyrep.PyRep``.
        robots: RLBench's folder ``robot_ttms``.
    """
    from pyrep.objects.dummy import Dummy

    robot = program.import_model(str(robots / "panda.ttm"))
    robot.set_position(list(ROBOT))
    _box("diningTable_visible", (1.4, 1.6, 0.04), (0.25, 0.0, TABLE - 0.021))
    _workspace()
    for number, (x, y, wide) in enumerate(((ROOM, 0, 0), (-ROOM, 0, 0), (0, ROOM, 1), (0, -ROOM, 1)), 1):
        size = (2 * ROOM, 0.05, 3.0) if wide else (0.05, 2 * ROOM, 3.0)
        _box(f"Wall{number}", size, (x, y, 1.5))
    _box("Roof", (2 * ROOM, 2 * ROOM, 0.05), (0.0, 0.0, 3.0))
    _box("Floor", (2 * ROOM, 2 * ROOM, 0.02), (0.0, 0.0, -0.02))
    # Programs that film an episode turn the base, and put a camera of their own at the placeholder.
    base = Dummy.create()
    base.set_name("cam_cinematic_base")
    base.set_position([WORKSPACE[0], WORKSPACE[1], TABLE])
    placeholder = Dummy.create()
    placeholder.set_name("cam_cinematic_placeholder")
    placeholder.set_parent(base)
    placeholder.set_matrix(_looking(CINEMATIC, _WATCHED))
    for name, place in CAMERAS.items():
        _camera(name, place)
        _camera(f"{name}_mask", place)


def _box(name: str, size: tuple[float, ...], place: tuple[float, ...]) -> None:
    from pyrep.const import PrimitiveShape
    from pyrep.objects.shape import Shape

    shape = Shape.create(
        PrimitiveShape.CUBOID, list(size), static=True, respondable=name == "diningTable_visible"
    )
    shape.set_name(name)
    shape.set_position(list(place))
    shape.set_color([0.8, 0.75, 0.65] if name == "diningTable_visible" else [0.85, 0.85, 0.85])
    shape.set_collidable(name == "diningTable_visible")


def _workspace() -> None:
    """Make a flat shape, which RLBench takes for a plane."""
    from pyrep.objects.shape import Shape

    x, y = (size / 2 for size in WORKSPACE_SIZE)
    corners = [-x, -y, 0.0, x, -y, 0.0, x, y, 0.0, -x, y, 0.0]
    shape = Shape.create_mesh(corners, [0, 1, 2, 0, 2, 3])
    shape.set_name("workspace")
    shape.set_position(list(WORKSPACE))
    for switch in (shape.set_collidable, shape.set_respondable, shape.set_dynamic, shape.set_renderable):
        switch(False)


def _camera(name: str, place: tuple[float, float, float]) -> None:
    from pyrep.const import RenderMode
    from pyrep.objects.vision_sensor import VisionSensor

    camera = VisionSensor.create(
        [128, 128],
        explicit_handling=True,
        view_angle=60.0,
        near_clipping_plane=0.01,
        far_clipping_plane=4.5,
        render_mode=RenderMode.OPENGL_COLOR_CODED if name.endswith("_mask") else RenderMode.OPENGL,
    )
    camera.set_name(name)
    camera.set_position(list(place))
    camera.set_matrix(_looking(place, _WATCHED))


def _looking(place: tuple[float, float, float], target: tuple[float, float, float]) -> Any:
    """Return the pose, 4 x 4, of a sensor that looks along its z axis at a target, with its y axis upwards."""
    import numpy as np

    z = np.subtract(target, place) / math.dist(target, place)
    x = np.cross((0.0, 0.0, 1.0), z)
    if not x.any():
        x = np.array((0.0, 1.0, 0.0))
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :3] = np.column_stack((x, np.cross(z, x), z))
    matrix[:3, 3] = place
    return matrix
