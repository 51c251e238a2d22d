"""Plug-ins of CoppeliaSim that the server does not have.

A script that requires one goes on: it gets a table whose functions fail when they are called, and the status bar says
what the plug-in did and what a script can do in its place.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

ADVICE: Mapping[str, str] = MappingProxyType(
    {
        "simThymio": "the robot Thymio's own programs do not run; a script moves its wheels with "
        "sim.setJointTargetVelocity, and reads its sensors with sim.readProximitySensor",
        "simSkeleton": "it is the example of a plug-in, without a use of its own",
        "simSubprocess": "scripts start no programs on the server; start them yourself, and let them call the server",
        "simOctomap": "octrees are not read from files and not written to files",
        "simCmd": "V-REP's command line belongs to its window",
        "simMujoco": "the scene's file defines what MuJoCo simulates, see docs/annotations.md",
        "simEigen": "sim has functions for poses and matrices, such as sim.multiplyPoses",
        "simEvents": "sim.setEventFilters and sysCall_event report changes",
        "simGLTF": "scenes are saved by sim.saveScene, and written as MJCF by simx-server --convert",
        "simGeom": "sim.checkCollision, sim.checkDistance and proximity sensors measure objects of the scene",
        "simICP": "point clouds are matched by a program outside, which reads them with sim.getPointCloudPoints",
        "simIGL": "simConvex, simOpenMesh and sim.getQHull work on meshes",
        "simIM": "simVision processes the images of vision sensors; programs outside have OpenCV",
        "simLDraw": "convert such models to OBJ or STL first; simAssimp.importShapes reads those",
        "simMIDI": "the server has no devices; a program outside can send what they do as signals",
        "simQML": "simUI makes windows, which the web viewer shows",
        "simSDF": "convert such models to URDF or MJCF first; sim.loadModel reads those",
        "simSurfRec": "sim.getQHull gives the hull of points",
        "simURLDrop": "load files with sim.loadModel",
        "simWS": "programs connect to the server itself: by ZeroMQ, Zenoh or ROS 2",
        "simPython": "scripts in Python run as they are",
        "simCodeEditor": "the server has no editor",
    }
)
"""Name to what a script can do in its place."""

_LUA = """\
local name, reason = {name}, {reason}
return setmetatable({{}}, {{ __index = function(_, member)
    return function() error(name .. "." .. tostring(member) .. ": " .. reason, 2) end
end }})
"""

_PYTHON = """\
def __getattr__(member):
    if member.startswith("__"):
        raise AttributeError(member)

    def missing(*_arguments, **_options):
        raise RuntimeError({name} + "." + member + ": " + {reason})

    return missing
"""

_TEXTS: Mapping[str, str] = MappingProxyType({"lua": _LUA, "python": _PYTHON})


def no_such_plugin(name: str, namespaces: Iterable[str]) -> str:
    """Return the message for a script that uses functions of a V-REP plugin that does not exist here."""
    known = ADVICE.get(name)
    return f"this server has no plug-in {name}" + (
        f": {known}" if known else f"; namespaces that scripts find are {', '.join(namespaces)}"
    )


def stand_in(name: str, language: str) -> bytes | None:
    """Return the text of a module in place of a plug-in, in ``lua`` or ``python``; None for any other name."""
    if name not in ADVICE:
        return None
    reason = no_such_plugin(name, ())
    # Names and reasons are plain texts without quotes and backslashes, so both languages read them alike.
    return _TEXTS[language].format(name=f'"{name}"', reason=f'"{reason}"').encode()
