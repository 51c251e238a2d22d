"""Meanings of arguments and results: an object's handle, a signal's name, a joint's position.

A meaning refines a kind (``kinds.py``). The kind defines the valid values and their encoding, the meaning their
purpose. The reference page, the command line, completion and `simx-check` read it here, so none of them guesses from
an argument's name.
"""

from __future__ import annotations

from dataclasses import replace
from enum import Enum
from typing import Any

from .. import kinds as k
from ..kinds import Kind
from ..python.light_dataclass import dataclass

REQUIRED: Any = object()
"""The value of `Meaning.omitted` where an argument must be given."""


class Role(Enum):
    """The effect of a call on the thing that an argument names."""

    NEEDS = "needs"
    """The thing must exist, or the call fails."""

    MAKES = "makes"
    """The call makes the thing."""

    REMOVES = "removes"
    """The call removes the thing, if it exists."""


@dataclass(frozen=True, slots=True)
class Meaning:
    """The meaning of one argument or result."""

    kind: Kind
    sentence: str = ""
    """A description with unit and frame, for the reference page."""

    sample: str = ""
    """Python text that stands for it in the example of the reference page; arguments only."""

    omitted: Any = REQUIRED
    """Its value when it is left out of a command line, where only the last arguments may be."""

    finder: str = ""
    """The function that finds a handle by a name, where the command line accepts the name too."""

    names: str = ""
    """The thing that a text names, for `simx-check`: an object, a scene file, a float signal."""

    role: Role = Role.NEEDS
    automatic: bool = False
    """The client id, the operation mode, the return code: command lines neither take nor show them."""

    def but(
        self, sentence: str | None = None, *, sample: str | None = None, omitted: Any = REQUIRED
    ) -> Meaning:
        """Return the same meaning in other words, or with another sample or default."""
        return replace(
            self,
            sentence=self.sentence if sentence is None else sentence,
            sample=self.sample if sample is None else sample,
            omitted=self.omitted if omitted is REQUIRED else omitted,
        )


# --- the connection -------------------------------------------------------------------------------

CLIENT_ID = Meaning(k.INT, "client id that simxStart returned", sample="client", automatic=True)
OPERATION_MODE = Meaning(
    k.INT,
    "operation mode; the call is blocking in every mode",
    sample="vrep.simx_opmode_blocking",
    automatic=True,
)
RETURN_CODE = Meaning(k.INT, "return code", automatic=True)
PORT = Meaning(k.INT, "TCP port, 1..65535", sample="19997", names="port")
TIME_OUT = Meaning(k.INT, "ms", sample="5000", omitted=5000)
SWITCH = Meaning(k.BOOL, "on or off", sample="True")

# --- handles --------------------------------------------------------------------------------------

OBJECT_HANDLE = Meaning(k.INT, "handle of an object", sample="box", finder="simxGetObjectHandle")
OBJECT_HANDLES = Meaning(k.INTS, "handles of objects", sample="[box]", finder="simxGetObjectHandle")
JOINT_HANDLE = OBJECT_HANDLE.but("handle of a joint", sample="joint")
VISION_SENSOR_HANDLE = OBJECT_HANDLE.but("handle of a vision sensor", sample="camera")
PROXIMITY_SENSOR_HANDLE = OBJECT_HANDLE.but("handle of a proximity sensor", sample="proximity_sensor")
FORCE_SENSOR_HANDLE = OBJECT_HANDLE.but("handle of a force sensor", sample="force_sensor")
REFERENCE_FRAME = OBJECT_HANDLE.but(
    "the frame: -1 world, -11 (sim_handle_parent) parent, or a handle", sample="-1", omitted=-1
)
COLLISION_HANDLE = Meaning(
    k.INT, "handle that simxGetCollisionHandle returned", sample="collision", finder="simxGetCollisionHandle"
)
DISTANCE_HANDLE = Meaning(
    k.INT, "handle that simxGetDistanceHandle returned", sample="distance", finder="simxGetDistanceHandle"
)
UI_HANDLE = Meaning(k.INT, "handle of a custom UI", sample="ui", finder="simxGetUIHandle")
CONSOLE_HANDLE = Meaning(k.INT, "handle of a console", sample="console")
DIALOG_HANDLE = Meaning(k.INT, "handle of a dialog", sample="dialog")
FOUND_HANDLE = Meaning(k.INT, "handle, -1 when the code is not 0")
HANDLE_OR_NONE = Meaning(k.INT, "handle, -1 for none")

# --- names and files ------------------------------------------------------------------------------

OBJECT_NAME = Meaning(k.TEXT, "name, `name#0`, or `/path/name[1]`", sample="'box'", names="object")
COLLECTION_NAME = Meaning(k.TEXT, "name, as registered in the scene", sample="'robot'", names="collection")
COLLISION_NAME = Meaning(k.TEXT, "name, as registered in the scene", sample="'bump'", names="collision")
DISTANCE_NAME = Meaning(k.TEXT, "name, as registered in the scene", sample="'gap'", names="distance")
UI_NAME = Meaning(k.TEXT, "name, as in its file", sample="'panel'", names="ui")
SCRIPT_OWNER = Meaning(
    k.TEXT, "name of the object that carries the script", sample="'base'", names="script owner"
)
SCRIPT_FUNCTION = Meaning(
    k.TEXT, "name of a function in the script; `table.name` too", sample="'double'", names="script function"
)
SCENE_FILE = Meaning(
    k.TEXT,
    "`.ttt`, MJCF or URDF file; without `x.ttt` that name loads the scene x",
    sample="'pioneer_p3dx.ttt'",
    names="scene file",
)
MODEL_FILE = Meaning(
    k.TEXT,
    "`.ttm`, MJCF, URDF, STL, OBJ, COLLADA or PLY file; without `x.ttm` that name loads the model x",
    sample="'models/robots/mobile/pioneer p3dx.ttm'",
    names="model file",
)
UI_FILE = Meaning(
    k.TEXT, "TOML or JSON file; `x.ttb` loads the file x", sample="'panel.toml'", names="ui file"
)
CLIENT_FILE = Meaning(k.TEXT, "path of a file on this machine", sample="'table.stl'")
WORKSPACE_FILE = Meaning(k.TEXT, "a plain name in the server's workspace", sample="'table.stl'")
LOAD_OPTIONS = Meaning(k.INT, "bit 0: the file is on the client's side", sample="0", omitted=0)


def signal_name(type: str, role: Role = Role.NEEDS) -> Meaning:
    """Return the meaning of a signal's name; its type is float, integer or string."""
    return Meaning(k.TEXT, "any text", sample="'speed'", names=f"{type} signal", role=role)


# --- positions, joints, images --------------------------------------------------------------------

POSITION = Meaning(k.VECTOR3, "m", sample="[0.5, 0, 1]")
EULER_ANGLES = Meaning(k.VECTOR3, "rad, R = Rx·Ry·Rz", sample="[0, 0, 1.57]")
QUATERNION = Meaning(k.VECTOR4, "x, y, z, w", sample="[0, 0, 0, 1]")
JOINT_POSITION = Meaning(k.FLOAT, "rad, or m", sample="0.5")
JOINT_MATRIX = Meaning(
    k.MATRIX12, "3 rows of 4, the last column in metres", sample="[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]"
)
FORCE = Meaning(k.FLOAT, "N m, or N of a prismatic joint", sample="10")
IMAGE = Meaning(k.PIXELS, "bottom row first; RGB, or grey with option bit 0", sample="bytes(32 * 24 * 3)")
IMAGE_OPTIONS = Meaning(k.INT, "bit 0: grey", sample="0", omitted=0)
RESOLUTION = Meaning(k.RESOLUTION, "pixels")

# --- parameters and settings ----------------------------------------------------------------------

OBJECT_TYPE = Meaning(k.INT, "a `sim_object_` type, or sim_handle_all", sample="vrep.sim_object_joint_type")
OBJECT_PARAMETER = Meaning(k.INT, "number of an object parameter, as in V-REP", sample="11")
SIMULATOR_PARAMETER = Meaning(
    k.INT,
    "a constant, `sim_boolparam_`, `sim_intparam_`, …",
    sample="vrep.sim_intparam_program_version",
)
BITS = Meaning(k.INT, "bits", sample="0")
BUTTON_ID = Meaning(k.INT, "number of the element", sample="3")
SLIDER_POSITION = Meaning(k.INT, "0..1000", sample="500")
COLOUR = Meaning(k.OPTIONAL_FLOATS3, "red, green, blue, 0..1", sample="None", omitted=None)
TWO_COLOURS = Meaning(k.OPTIONAL_FLOATS6, "two colours, 0..1", sample="None", omitted=None)
