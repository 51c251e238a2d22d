"""Assemble the ``sim`` object of a script: one public method per function, named as in V-REP, one file per topic.

The methods use the same code as the remote commands, so a script and a client get the same numbers and the same
errors. A new function is a new method in the file of its topic; a new topic is a new class here.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from simx_client.protocol import constants

from .base import HANDLE_SELF, ApiPart
from .custom_uis import CustomUIFunctions
from .engine import EngineFunctions
from .graphs import GraphFunctions
from .main_scripts import MainScriptFunctions
from .messages import MessageFunctions
from .motion.configurations import ConfigurationFunctions
from .motion.ik import IkFunctions
from .motion.motion import MotionFunctions
from .motion.moves import MoveFunctions
from .motion.old_moves import OldMoveFunctions
from .motion.ompl import OmplFunctions
from .motion.ompl_flat import FlatOmplFunctions
from .motion.profiles import ProfileFunctions
from .motion.sim_ik_worlds import SimIk
from .objects.collisions import CollisionFunctions
from .objects.custom_data import CustomDataFunctions
from .objects.drawing import DrawingFunctions
from .objects.dynamics import DynamicsFunctions
from .objects.joints import JointFunctions
from .objects.object_names import ObjectNameFunctions
from .objects.object_parameters import ObjectParameterFunctions
from .objects.objects import ObjectFunctions
from .objects.poses import PoseFunctions
from .objects.selection import SelectionFunctions
from .objects.sensors import SensorFunctions
from .objects.shapes import ShapeFunctions
from .parameters import ParameterFunctions
from .remote_api import RemoteApiFunctions, RemoteApiNamespace
from .scripts import ScriptFunctions
from .signals import SignalFunctions
from .simulation import SimulationFunctions
from .simx import SimxFunctions
from .threads import ThreadFunctions
from .tubes import TubeFunctions
from .values.bits import BitFunctions
from .values.buffers import BufferFunctions
from .values.matrices import MatrixFunctions
from .values.packing import PackingFunctions
from .vision.sim_vision import SimVision
from .vision.vision import VisionFunctions
from .window import WindowFunctions

__all__ = ["HANDLE_SELF", "NAMESPACES", "ApiPart", "SimApi", "known_constants"]

_LATER_CONSTANTS = MappingProxyType(
    {
        "handleflag_axis": 0x400000,
        "handle_scene": -12,
        "handle_app": -13,
        "verbosity_none": 100,
        "verbosity_errors": 200,
        "verbosity_warnings": 300,
        "verbosity_loadinfos": 400,
        "verbosity_scripterrors": 420,
        "verbosity_scriptwarnings": 430,
        "verbosity_scriptinfos": 450,
        "verbosity_msgs": 450,
        "verbosity_infos": 500,
        "verbosity_debug": 600,
        "verbosity_trace": 700,
    }
)
"""Constants that scripts use and that the remote API's module does not have."""


class SimApi(
    ObjectFunctions,
    PoseFunctions,
    JointFunctions,
    SensorFunctions,
    CollisionFunctions,
    SignalFunctions,
    SimulationFunctions,
    MessageFunctions,
    ThreadFunctions,
    BitFunctions,
    BufferFunctions,
    ConfigurationFunctions,
    CustomDataFunctions,
    CustomUIFunctions,
    TubeFunctions,
    DynamicsFunctions,
    EngineFunctions,
    MatrixFunctions,
    ObjectNameFunctions,
    ObjectParameterFunctions,
    PackingFunctions,
    ParameterFunctions,
    SelectionFunctions,
    WindowFunctions,
    VisionFunctions,
    ShapeFunctions,
    DrawingFunctions,
    ScriptFunctions,
    RemoteApiFunctions,
    MainScriptFunctions,
    GraphFunctions,
    IkFunctions,
    FlatOmplFunctions,
    ProfileFunctions,
    MotionFunctions,
    MoveFunctions,
    OldMoveFunctions,
):
    """All functions of ``sim``, for one script."""


NAMESPACES: Mapping[str, type[ApiPart]] = MappingProxyType(
    {
        "sim": SimApi,
        "simIK": SimIk,
        "simOMPL": OmplFunctions,
        "simRemoteApi": RemoteApiNamespace,
        "simVision": SimVision,
        "simx": SimxFunctions,
    }
)
"""Globals of scripts; each is a class assembled as `SimApi` is."""


@cache
def known_constants() -> Mapping[str, int]:
    """Return the constants ``sim_NAME`` of the remote API, keyed by ``NAME``."""
    found = {
        name.removeprefix("sim_"): value
        for name, value in vars(constants).items()
        if name.startswith("sim_") and isinstance(value, int)
    }
    return MappingProxyType(found | dict(_LATER_CONSTANTS))
