"""Build a world: the only module that knows which part needs which."""

from __future__ import annotations

from pathlib import Path

from simx_server.files.scene_files import SceneFiles
from simx_server.kinematics import IkGroups
from simx_server.limits import Limits
from simx_server.parts.custom_data import CustomData
from simx_server.parts.drawing import DrawingObjects
from simx_server.parts.graphs import Graphs
from simx_server.parts.object_settings import ObjectSettings
from simx_server.parts.parameters import Parameters
from simx_server.parts.selection import Selection
from simx_server.parts.signals import Signals
from simx_server.parts.status_bar import StatusBar
from simx_server.parts.tubes import Tubes
from simx_server.parts.user_interface import ADD_ON_NAME, UserInterface, UserInterfaceAddOn
from simx_server.scene.collection import Collections
from simx_server.scene.formats.sources import Sources
from simx_server.scene.trial.trials import Trials
from simx_server.scene.unreset import UnresetModels
from simx_server.scripting import Scripts
from simx_server.scripting.namespaces import Namespaces
from simx_server.scripting.script import Script
from simx_server.scripting.script_parameters import ScriptParameters
from simx_server.sensors.distance.meters import Meters
from simx_server.sensors.force import ForceSensors
from simx_server.sensors.instant import Instants
from simx_server.sensors.proximity.proximity import ProximitySensors
from simx_server.sensors.vision.render_thread import RenderThread
from simx_server.sensors.vision.vision_sensors import VisionSensors

from .applied_forces import AppliedForces
from .simulation import Simulation
from .velocities import Velocities
from .world import World


def build_world(
    rendering: RenderThread,
    *,
    workspace: Path | None = None,
    limits: Limits | None = None,
    sources: Sources | None = None,
    own_scene: Path | None = None,
    allows_code: bool = False,
    tries_all: bool = False,
    arguments: tuple[str, ...] = (),
) -> World:
    """Return a world with the empty scene.

    Args:
        rendering: renders the images; the caller closes it.
        workspace: the only folder, beside the shipped scenes and the folder of the present scene, from which
            clients may load files; the working directory if None.
        limits: how much clients may make the server hold.
        sources: further places to search the files that scenes and models reference.
        own_scene: the scene that the server starts with; the operator trusts the files that it references.
        allows_code: scripts may run code that clients send.
        tries_all: the operator's own files are tried in a child process too.
        arguments: of the server, for programs that read them as string parameters.
    """
    files = SceneFiles(workspace or Path.cwd(), sources, own_scene)
    sim = Simulation(limits, files)
    signals = Signals(sim)
    status_bar = StatusBar()
    collections = Collections(sim)
    instants = Instants(sim)
    meters = Meters(sim, collections, instants)
    proximity = ProximitySensors(sim, collections, instants)
    vision = VisionSensors(sim, rendering)
    trials = Trials(sim, tries_all=tries_all)
    object_settings = ObjectSettings(sim)
    user_interface = UserInterface(sim, status_bar, trials)

    def open_spaces(script: Script) -> Namespaces:
        return Namespaces(world, script)

    world = World(
        simulation=sim,
        velocities=Velocities(sim),
        applied_forces=AppliedForces(sim),
        signals=signals,
        status_bar=status_bar,
        selection=Selection(),
        custom_data=CustomData(sim),
        object_settings=object_settings,
        collections=collections,
        instants=instants,
        meters=meters,
        proximity=proximity,
        force=ForceSensors(sim),
        rendering=rendering,
        vision=vision,
        tubes=Tubes(sim),
        script_parameters=ScriptParameters(sim),
        scripts=Scripts(sim, signals, status_bar, vision, proximity, open_spaces, allows_code=allows_code),
        ik_groups=IkGroups(sim, collections),
        drawings=DrawingObjects(sim),
        graphs=Graphs(sim),
        trials=trials,
        user_interface=user_interface,
        parameters=Parameters(
            sim, meters, proximity, vision, object_settings, user_interface, arguments=arguments
        ),
    )
    world.scripts.add_ons[ADD_ON_NAME] = UserInterfaceAddOn(user_interface)
    # Scripts are notified after the parts that they call.
    sim.attach(
        world.velocities,
        world.selection,
        world.custom_data,
        world.object_settings,
        world.parameters,
        world.collections,
        world.meters,
        world.proximity,
        world.force,
        world.vision,
        world.tubes,
        world.script_parameters,
        world.scripts,
        world.ik_groups,
        world.drawings,
        world.graphs,
        UnresetModels(sim),
        world.user_interface,
    )
    return world
