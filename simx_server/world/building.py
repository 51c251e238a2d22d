"""What a simulation needs beside physics to behave like V-REP: sensors, parameters, user interface, scripts.

`attach_parts` is the one place that knows them all; the handlers and the scripts' ``sim`` find them as attributes
of the simulation.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from simx_server.files.client_files import ClientFiles
from simx_server.kinematics import IkGroups
from simx_server.limits import Limits
from simx_server.parts.custom_data import CustomData
from simx_server.parts.drawing import DrawingObjects
from simx_server.parts.graphs import Graphs
from simx_server.parts.object_settings import ObjectSettings
from simx_server.parts.parameters import Parameters
from simx_server.parts.status_bar import StatusBar
from simx_server.parts.tubes import Tubes
from simx_server.parts.user_interface import ADD_ON_NAME, UserInterface, UserInterfaceAddOn
from simx_server.scene.collection import Collections
from simx_server.scene.trial.trials import Trials
from simx_server.scene.unreset import UnresetModels
from simx_server.scripting import Scripts
from simx_server.scripting.script_parameters import ScriptParameters
from simx_server.sensors.distance.meters import Meters
from simx_server.sensors.force import ForceSensors
from simx_server.sensors.instant import Instants
from simx_server.sensors.proximity.proximity import ProximitySensors
from simx_server.sensors.vision.vision_sensors import VisionSensors

from .applied_forces import AppliedForces

if TYPE_CHECKING:
    from .simulation import Simulation


def attach_parts(sim: Simulation, workspace: Path | None = None, limits: Limits | None = None) -> None:
    """Give a simulation its parts; to be called once, before its first scene is loaded.

    `workspace` is the only folder, beside the shipped scenes and that of the present scene, from which clients may
    load scenes; the working directory if None. Pictures also need `sim.rendering`, a RenderThread.
    """
    if limits is not None:
        sim.limits = limits
    sim.workspace = (workspace or Path.cwd()).resolve()
    sim.stored = {}
    sim.client_files = ClientFiles(sim.workspace)
    sim.trials = Trials(sim)
    _select_nothing(sim)
    for happened in (sim.on_load, sim.on_close):
        happened.append(partial(_select_nothing, sim))  # another scene may have the same handles
    sim.status_bar = StatusBar()
    sim.applied_forces = AppliedForces(sim)
    sim.custom_data = CustomData(sim)
    sim.object_settings = ObjectSettings(sim)
    sim.parameters = Parameters(sim)
    sim.collections = Collections(sim)
    sim.instants = Instants(sim)
    sim.meters = Meters(sim)
    sim.proximity = ProximitySensors(sim)
    sim.force = ForceSensors(sim)
    sim.vision = VisionSensors(sim)
    sim.tubes = Tubes(sim)
    sim.script_parameters = ScriptParameters(sim)
    sim.scripts = Scripts(sim)
    sim.ik_groups = IkGroups(sim)  # after the scripts, whose actuation moves the targets
    sim.drawings = DrawingObjects(sim)
    sim.graphs = Graphs(sim)
    UnresetModels(sim)
    sim.user_interface = UserInterface(sim)
    sim.scripts.add_ons[ADD_ON_NAME] = UserInterfaceAddOn(sim.user_interface)


def _select_nothing(sim: Simulation) -> None:
    sim.selection = []
