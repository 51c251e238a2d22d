"""The functions of API 1 that methods call, as one type. `SimApi` has them all."""

from __future__ import annotations

from simx_server.sim_api.clouds.octrees import OctreeFunctions
from simx_server.sim_api.clouds.point_clouds import PointCloudFunctions
from simx_server.sim_api.graphs import GraphFunctions
from simx_server.sim_api.looks.colors import ColorFunctions
from simx_server.sim_api.looks.drawing import DrawingFunctions
from simx_server.sim_api.looks.textures import TextureFunctions
from simx_server.sim_api.messages import MessageFunctions
from simx_server.sim_api.objects.collisions import CollisionFunctions
from simx_server.sim_api.objects.compounds import CompoundFunctions
from simx_server.sim_api.objects.dynamics import DynamicsFunctions
from simx_server.sim_api.objects.joints import JointFunctions
from simx_server.sim_api.objects.meshes import MeshFunctions
from simx_server.sim_api.objects.object_names import ObjectNameFunctions
from simx_server.sim_api.objects.objects import ObjectFunctions
from simx_server.sim_api.objects.poses import PoseFunctions
from simx_server.sim_api.objects.sensors import SensorFunctions
from simx_server.sim_api.objects.shapes import ShapeFunctions
from simx_server.sim_api.objects.sizes import SizeFunctions
from simx_server.sim_api.paths.path_making import PathMakingFunctions
from simx_server.sim_api.plugins import PluginFunctions
from simx_server.sim_api.processes import ProcessFunctions
from simx_server.sim_api.scripts.events import EventFunctions
from simx_server.sim_api.scripts.main_scripts import MainScriptFunctions
from simx_server.sim_api.scripts.making import ScriptMakingFunctions
from simx_server.sim_api.scripts.scheduling import SchedulingFunctions
from simx_server.sim_api.scripts.scripts import ScriptFunctions
from simx_server.sim_api.scripts.threads import ThreadFunctions
from simx_server.sim_api.simulation import SimulationFunctions
from simx_server.sim_api.stand_ins.window import WindowFunctions
from simx_server.sim_api.user_interface.text_editors import TextEditorFunctions
from simx_server.sim_api.values.buffers import BufferFunctions
from simx_server.sim_api.values.matrices import MatrixFunctions
from simx_server.sim_api.values.packing import PackingFunctions
from simx_server.sim_api.vision.image_files import ImageFileFunctions
from simx_server.sim_api.vision.vision import VisionFunctions


class Api1(
    ObjectFunctions,
    ObjectNameFunctions,
    PoseFunctions,
    JointFunctions,
    SensorFunctions,
    VisionFunctions,
    ImageFileFunctions,
    CollisionFunctions,
    DynamicsFunctions,
    ShapeFunctions,
    SizeFunctions,
    MeshFunctions,
    CompoundFunctions,
    ColorFunctions,
    TextureFunctions,
    DrawingFunctions,
    PointCloudFunctions,
    OctreeFunctions,
    GraphFunctions,
    PathMakingFunctions,
    MatrixFunctions,
    BufferFunctions,
    PackingFunctions,
    SimulationFunctions,
    MessageFunctions,
    PluginFunctions,
    ProcessFunctions,
    ScriptFunctions,
    ScriptMakingFunctions,
    SchedulingFunctions,
    EventFunctions,
    MainScriptFunctions,
    ThreadFunctions,
    TextEditorFunctions,
    WindowFunctions,
):
    """A part of `SimApi`, named for the types of its functions."""
