"""The add-on `PyRep`: PyRep installs a Lua script of this name, and these are our forms of its functions.

sim.callScriptFunction("getNonlinearPath@PyRep", 2, ints, floats, strings, "")

==================================  =========================================  ===========================
function                            integers; floats; strings                  floats of the result
==================================  =========================================  ===========================
getNonlinearPath                    collection, 1 to ignore collisions,        at least 300 configurations;
                                    trials, joints; goal configurations;       none without a path
                                    name of an algorithm
getNonlinearPathMobile              robot, target, collection, 1 to ignore     x, y, yaw of each state; none
                                    collisions, number of states; bound in m;  without a path
                                    name of an algorithm
getPathFromCartesianPath            path, IK group, target dummy, joints       20 configurations up to each of
                                                                               20 places; none on failure
insertPathControlPoint              path, count; position and Euler angles
                                    of each
getBoxAdjustedMatrixAndFacingAngle  base, target                               12 of a matrix, an angle
handleSpherical                     depth sensor, colour sensor, six sensors
==================================  =========================================  ===========================
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from simx_server.parts.add_ons import Functions, Results
from simx_server.scripting.script import Script, ScriptKind

from .planned_paths import PlannedPaths
from .scene_functions import SceneFunctions

if TYPE_CHECKING:
    from simx_server.world.world import World

NAME = "PyRep"

_HANDLE = 2_000_001
"""Of its script, which has no text: below the handles of all others."""


class PyRepAddOn:
    """Call functions by name, with the four tables of PyRep's `script_call`."""

    def __init__(self, world: World) -> None:
        script = Script(_HANDLE, ScriptKind.CUSTOMIZATION, -1, NAME, text="")
        paths, scene = PlannedPaths(world), SceneFunctions(world, script)
        self._functions = Functions[Callable[[list[int], list[float], list[str]], list[float]]](
            NAME,
            {
                "getNonlinearPath": (None, None, paths.of_arm),
                "getNonlinearPathMobile": (5, 1, paths.of_mobile),
                "getPathFromCartesianPath": (None, None, scene.follow_path),
                "insertPathControlPoint": (2, None, scene.insert_control_points),
                "getBoxAdjustedMatrixAndFacingAngle": (2, 0, scene.face),
                "handleSpherical": (8, 0, scene.handle_spherical),
            },
        )

    def call(
        self, function: str, ints: list[int], floats: list[float], strings: list[str], buffer: bytes
    ) -> Results:
        """Call a function.

        Raises:
            CommandError: no such function, other arguments, or an error of the function.
        """
        return [], self._functions.find(function, ints, floats)(ints, floats, strings), [], b""
