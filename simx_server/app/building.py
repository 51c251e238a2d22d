"""Build a world: the only module that knows which part needs which."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from simx_client.protocol.add_ons.teleoperation import ADD_ON as TELEOPERATION
from simx_server.handlers.files import store_file
from simx_server.kinematics import IkGroups
from simx_server.kinematics.planning.scene_tasks.motion_plannings import MotionPlannings
from simx_server.kinematics.planning.scene_tasks.path_plannings import PathPlannings
from simx_server.kinematics.searching import Searching
from simx_server.limits import Limits
from simx_server.parts.add_ons import AddOn, Deferred
from simx_server.parts.clouds.clouds import PointClouds
from simx_server.parts.communication.ros2_topics import Ros2Topics
from simx_server.parts.communication.script_ports import ScriptPorts
from simx_server.parts.communication.semaphores import Semaphores
from simx_server.parts.communication.signals import Signals
from simx_server.parts.communication.simulator_messages import SimulatorMessages
from simx_server.parts.communication.tubes import Tubes
from simx_server.parts.communication.wireless import Wireless
from simx_server.parts.custom_data import CustomData
from simx_server.parts.drawing import DrawingObjects
from simx_server.parts.dummy_links import DummyLinks
from simx_server.parts.graphs import Graphs
from simx_server.parts.instances import Instances
from simx_server.parts.machine.outside import Outside
from simx_server.parts.machine.programs import Programs
from simx_server.parts.machine.serial_ports import SerialPorts
from simx_server.parts.object_settings import ObjectSettings
from simx_server.parts.origins import Origins
from simx_server.parts.parameters import Parameters
from simx_server.parts.particles import Particles
from simx_server.parts.paths.paths import Paths
from simx_server.parts.plugin_infos import PluginInfos
from simx_server.parts.selection import Selection
from simx_server.parts.shape_colors import ShapeColors
from simx_server.parts.status_bar import StatusBar
from simx_server.parts.textures.textures import Textures
from simx_server.parts.user_interface.add_on import ADD_ON_NAME, UserInterfaceAddOn
from simx_server.parts.user_interface.interface import UserInterface
from simx_server.parts.written_files import WrittenFiles
from simx_server.scene.collection import Collections
from simx_server.scene.finding.scene_files import SceneFiles
from simx_server.scene.formats.kept_models import KeptModels
from simx_server.scene.formats.sources import Sources
from simx_server.scene.trial.trials import Trials
from simx_server.scripting.script import Script
from simx_server.scripting.script_parameters import ScriptParameters
from simx_server.scripting.scripts import Scripts
from simx_server.sensors.contacts import Contacts
from simx_server.sensors.distance.meters import Meters
from simx_server.sensors.force import ForceSensors
from simx_server.sensors.instant import Instants
from simx_server.sensors.proximity.proximity import ProximitySensors
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.sensors.vision.vision_sensors import VisionSensors
from simx_server.simulation.applied_forces import AppliedForces
from simx_server.simulation.physics import Physics
from simx_server.simulation.simulation import Simulation
from simx_server.simulation.surfaces import Surfaces
from simx_server.simulation.unreset import UnresetModels
from simx_server.simulation.velocities import Velocities
from simx_server.teleoperation.arm_drive import ArmDrive
from simx_server.world.world import World

from .import_log import ImportLog

if TYPE_CHECKING:
    from simx_server.sim_api.namespaces import Namespaces


def build_world(
    rendering: RenderThread,
    *,
    workspace: Path | None = None,
    limits: Limits | None = None,
    sources: Sources | None = None,
    own_scene: Path | None = None,
    allows_code: bool = False,
    allows_machine: bool = False,
    needs_seccomp: bool = True,
    tries_all: bool = False,
    arguments: tuple[str, ...] = (),
    searching: Searching = Searching(),  # noqa: B008  # it is frozen
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
        allows_machine: scripts may start programs and open serial ports.
        needs_seccomp: Python scripts do not run where the kernel cannot restrict their system calls.
        tries_all: the operator's own files are tried in a child process too.
        arguments: of the server, for programs that read them as string parameters.
        searching: how inverse kinematics and planners search.
    """
    files = SceneFiles(workspace or Path.cwd(), sources, own_scene)
    sim = Simulation(limits, files)
    surfaces = Surfaces(sim)
    signals = Signals(sim)
    status_bar = StatusBar()
    collections = Collections(sim)
    clouds, textures = PointClouds(sim), Textures(sim)
    instants = Instants(sim, clouds.show)
    meters = Meters(sim, collections, instants)
    proximity = ProximitySensors(sim, collections, instants)
    force = ForceSensors(sim)

    def show_changes() -> None:
        clouds.show()
        textures.show()

    vision = VisionSensors(sim, rendering, collections, show_changes)
    trials = Trials(sim, tries_all=tries_all)
    object_settings = ObjectSettings(sim, surfaces)
    paths = Paths(sim)
    outside = Outside()
    user_interface = UserInterface(sim, status_bar, trials)

    script_ports = ScriptPorts(sim, status_bar)
    ik_groups = IkGroups(sim, collections, searching.seed)

    # Only scripts and programs of the ZeroMQ remote API need these: a quarter of the server's modules.
    def open_spaces(script: Script) -> Namespaces:
        from simx_server.sim_api.namespaces import Namespaces

        return Namespaces(world, script)

    def pyrep() -> AddOn:
        from simx_server.sim_api.pyrep.add_on import PyRepAddOn

        return PyRepAddOn(world)

    def teleoperation() -> AddOn:
        from simx_server.teleoperation.add_on import TeleoperationAddOn

        return TeleoperationAddOn(sim, ik_groups, signals, world.scripts, world.arm_drive)

    def descriptions() -> Mapping[str, str]:
        from simx_server.sim_api.listing import coverage

        return coverage.descriptions()

    def another() -> World:
        return build_world(rendering, workspace=files.workspace, limits=limits, searching=searching)

    def store(name: str, data: bytes) -> None:
        store_file(world, name, data)

    world = World(
        simulation=sim,
        physics=Physics(sim),
        surfaces=surfaces,
        velocities=Velocities(sim),
        applied_forces=AppliedForces(sim),
        signals=signals,
        status_bar=status_bar,
        selection=Selection(),
        simulator_messages=SimulatorMessages(),
        custom_data=CustomData(sim),
        object_settings=object_settings,
        origins=Origins(sim),
        shape_colors=ShapeColors(sim),
        dummy_links=DummyLinks(sim),
        collections=collections,
        instants=instants,
        meters=meters,
        proximity=proximity,
        force=force,
        contacts=Contacts(sim),
        rendering=rendering,
        vision=vision,
        tubes=Tubes(sim),
        wireless=Wireless(sim),
        semaphores=Semaphores(),
        outside=outside,
        serial_ports=SerialPorts(sim, outside, is_allowed=allows_machine),
        programs=Programs(outside, files.workspace, is_allowed=allows_machine),
        script_parameters=ScriptParameters(sim),
        script_ports=script_ports,
        written_files=WrittenFiles(sim, store, status_bar),
        ros2_topics=Ros2Topics(sim),
        scripts=Scripts(
            sim,
            signals,
            status_bar,
            vision,
            proximity,
            force,
            open_spaces,
            script_ports.name,
            descriptions,
            allows_code=allows_code,
            needs_seccomp=needs_seccomp,
        ),
        searching=searching,
        ik_groups=ik_groups,
        arm_drive=ArmDrive(sim, ik_groups),
        path_plannings=PathPlannings(sim),
        motion_plannings=MotionPlannings(sim),
        paths=paths,
        clouds=clouds,
        textures=textures,
        drawings=DrawingObjects(sim),
        instances=Instances(sim),
        particles=Particles(sim),
        plugin_infos=PluginInfos(),
        graphs=Graphs(sim, proximity, meters),
        trials=trials,
        kept_models=KeptModels(),
        user_interface=user_interface,
        parameters=Parameters(sim, arguments),
        another=another,
    )
    world.scripts.add_ons[ADD_ON_NAME] = UserInterfaceAddOn(user_interface)
    world.scripts.add_ons["PyRep"] = Deferred(pyrep)
    world.scripts.add_ons[TELEOPERATION] = Deferred(teleoperation)
    # Scripts are notified after the parts that they call.
    sim.parts.attach(
        world.physics,  # it may refuse a start
        world.surfaces,
        world.velocities,
        world.selection,
        world.simulator_messages,
        world.custom_data,
        world.object_settings,
        world.origins,
        world.shape_colors,
        world.dummy_links,
        world.paths,
        world.clouds,
        world.textures,
        world.parameters,
        world.collections,
        world.meters,
        world.proximity,
        world.force,
        world.contacts,
        world.vision,
        world.tubes,
        world.wireless,
        world.script_parameters,
        world.script_ports,
        world.serial_ports,
        world.user_interface,
        world.graphs,
        world.scripts,
        world.written_files,  # after the scripts, which write at their end
        world.ros2_topics,  # closes those of scripts that have ended
        world.ik_groups,
        world.arm_drive,
        world.path_plannings,
        world.motion_plannings,
        world.drawings,
        world.instances,
        world.particles,
        world.plugin_infos,
        UnresetModels(sim),
        ImportLog(),
    )
    return world
