"""Assemble the ``sim`` object of a script: one public method per function, named as in V-REP, one file per topic.

The methods use the same code as the remote commands, so a script and a client get the same numbers and the same
errors. A new function is a new method in the file of its topic; a new topic is a new class here.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from simx_client.protocol import constants
from simx_server.constant_tables import TABLES

from .base import HANDLE_SELF, ApiPart
from .clouds.octrees import OctreeFunctions
from .clouds.point_clouds import PointCloudFunctions
from .communication.signals import SignalFunctions
from .communication.tubes import TubeFunctions
from .communication.wireless import WirelessFunctions
from .engine import EngineFunctions
from .graphs import GraphFunctions
from .kinematics.ik import IkFunctions
from .kinematics.ik_making import IkMakingFunctions
from .kinematics.sim_ik_worlds import SimIk
from .listing.api_listing import ApiListingFunctions
from .looks.colors import ColorFunctions
from .looks.drawing import DrawingFunctions
from .looks.particles import ParticleFunctions
from .looks.textures import TextureFunctions
from .mesh_plugins.sim_assimp import SimAssimp
from .mesh_plugins.sim_convex import SimConvex, SimOpenMesh
from .mesh_plugins.sim_urdf import SimUrdf
from .messages import MessageFunctions
from .motion.configurations import ConfigurationFunctions
from .motion.motion import MotionFunctions
from .motion.moves import MoveFunctions
from .motion.old_moves import OldMoveFunctions
from .motion.profiles import ProfileFunctions
from .named_parameters import NamedParameterFunctions
from .object_model.functions import ObjectModelFunctions
from .objects.collisions import CollisionFunctions
from .objects.compounds import CompoundFunctions
from .objects.custom_data import CustomDataFunctions
from .objects.dynamics import DynamicsFunctions
from .objects.hierarchy import HierarchyFunctions
from .objects.joints import JointFunctions
from .objects.meshes import MeshFunctions
from .objects.object_names import ObjectNameFunctions
from .objects.object_parameters import ObjectParameterFunctions
from .objects.objects import ObjectFunctions
from .objects.poses import PoseFunctions
from .objects.selection import SelectionFunctions
from .objects.sensors import SensorFunctions
from .objects.shapes import ShapeFunctions
from .objects.sizes import SizeFunctions
from .parameters import ParameterFunctions
from .paths.flat_paths import FlatPathFunctions
from .paths.following import PathFollowingFunctions
from .paths.path_making import PathMakingFunctions
from .paths.path_objects import PathObjectFunctions
from .paths.path_planning import PathPlanningFunctions
from .planning.motion_planning import MotionPlanningFunctions
from .planning.ompl import OmplFunctions
from .planning.ompl_flat import FlatOmplConstants
from .plugins import PluginFunctions
from .processes import ProcessFunctions
from .properties.functions import PropertyFunctions
from .properties.typed_functions import SinglePropertyFunctions, TablePropertyFunctions
from .remote_api import RemoteApiFunctions, RemoteApiNamespace
from .ros2.sim_ros2 import SimRos2
from .scripts.attributes import ScriptAttributeFunctions
from .scripts.events import EventFunctions
from .scripts.main_scripts import MainScriptFunctions
from .scripts.making import ScriptMakingFunctions
from .scripts.scheduling import SchedulingFunctions
from .scripts.scripts import ScriptFunctions
from .scripts.threads import ThreadFunctions
from .simulation import SimulationFunctions
from .simx import SimxFunctions
from .stand_ins.devices import SimChai3d, SimMtb
from .stand_ins.messaging import SimB0, SimZmq
from .stand_ins.ros import OldRosFunctions, SimRos
from .stand_ins.ros_bridge import RosBridgeFunctions
from .stand_ins.window import WindowFunctions
from .user_interface.old_uis import CustomUIFunctions
from .user_interface.sim_ui_namespace import SimUi
from .user_interface.text_editors import TextEditorFunctions
from .user_interface.views import ViewFunctions
from .values.bits import BitFunctions
from .values.buffers import BufferFunctions
from .values.matrices import MatrixFunctions
from .values.packing import PackingFunctions
from .vision.image_files import ImageFileFunctions
from .vision.sim_vision import SimVision
from .vision.vision import VisionFunctions

__all__ = ["HANDLE_SELF", "NAMESPACES", "ApiPart", "SimApi", "known_constants"]


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
    WirelessFunctions,
    DynamicsFunctions,
    EngineFunctions,
    MatrixFunctions,
    HierarchyFunctions,
    ObjectNameFunctions,
    ObjectParameterFunctions,
    PackingFunctions,
    ParameterFunctions,
    NamedParameterFunctions,
    PropertyFunctions,
    SinglePropertyFunctions,
    TablePropertyFunctions,
    SelectionFunctions,
    ViewFunctions,
    TextEditorFunctions,
    WindowFunctions,
    VisionFunctions,
    ImageFileFunctions,
    ShapeFunctions,
    MeshFunctions,
    CompoundFunctions,
    ColorFunctions,
    TextureFunctions,
    SizeFunctions,
    DrawingFunctions,
    PointCloudFunctions,
    OctreeFunctions,
    ParticleFunctions,
    ScriptFunctions,
    ScriptAttributeFunctions,
    ScriptMakingFunctions,
    SchedulingFunctions,
    EventFunctions,
    PluginFunctions,
    ProcessFunctions,
    RemoteApiFunctions,
    OldRosFunctions,
    RosBridgeFunctions,
    MainScriptFunctions,
    GraphFunctions,
    IkFunctions,
    IkMakingFunctions,
    FlatOmplConstants,
    ProfileFunctions,
    MotionFunctions,
    MoveFunctions,
    OldMoveFunctions,
    PathObjectFunctions,
    PathMakingFunctions,
    PathFollowingFunctions,
    PathPlanningFunctions,
    MotionPlanningFunctions,
    FlatPathFunctions,
    ApiListingFunctions,
    ObjectModelFunctions,
):
    """All functions of ``sim``, for one script."""


NAMESPACES: Mapping[str, type[ApiPart]] = MappingProxyType(
    {
        "sim": SimApi,
        "simIK": SimIk,
        "simAssimp": SimAssimp,
        "simConvex": SimConvex,
        "simOMPL": OmplFunctions,
        "simOpenMesh": SimOpenMesh,
        "simRemoteApi": RemoteApiNamespace,
        "simROS": SimRos,
        "simROS2": SimRos2,
        "simUI": SimUi,
        "simURDF": SimUrdf,
        "simVision": SimVision,
        "simx": SimxFunctions,
        "simB0": SimB0,
        "simCHAI3D": SimChai3d,
        "simMTB": SimMtb,
        "simZMQ": SimZmq,
    }
)
"""Globals of scripts; each is a class assembled as `SimApi` is."""


@cache
def known_constants() -> Mapping[str, int]:
    """Return V-REP's constants ``sim_NAME`` by ``NAME``: those of the remote API, and all others."""
    found = {
        name.removeprefix("sim_"): value
        for name, value in vars(constants).items()
        if name.startswith("sim_") and isinstance(value, int)
    }
    return MappingProxyType({**TABLES, **found})
