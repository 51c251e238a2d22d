"""Path planning tasks of a V-REP file."""

from __future__ import annotations

import math

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Path, PathPlanning

_TYPES = {0: "xy", 2: "xyz", 3: "xyg", 8: "xyzabg"}
"""Types that the planner here knows, with the file's numbers."""


def add_path_plannings(conversion: Conversion) -> None:
    """Annotate the path planning tasks; called when all objects were added."""
    for planning in conversion.file.path_plannings:
        _add(conversion, planning)


def _add(conversion: Conversion, planning: PathPlanning) -> None:
    names, report = conversion.names, conversion.report
    is_path = isinstance(conversion.file.objects.get(planning.path), Path)
    robot, obstacles = conversion.entity(planning.robot), conversion.entity(planning.obstacles)
    kind = _TYPES.get(planning.type)
    bounds = (*planning.low, *planning.high)
    if not is_path or planning.start not in names or planning.goal not in names or robot is None:
        report.leave_out("path planning tasks without path, start, goal or robot", planning.name)
    elif kind is None or not planning.name or not all(map(math.isfinite, bounds)):
        report.leave_out(
            "path planning tasks of other types than x y, x y z, x y gamma, and poses", planning.name
        )
    else:
        conversion.annotate(
            "planning",
            planning.name,
            path=names[planning.path],
            start=names[planning.start],
            goal=names[planning.goal],
            robot=None if robot == "all" else robot,
            obstacles=obstacles,
            type=kind,
            low=_text(planning.low),
            high=_text(planning.high),
            seconds=planning.seconds if planning.seconds > 0 else None,
        )


def _text(numbers: tuple[float, ...]) -> str:
    return ",".join(f"{number:.9g}" for number in numbers)
