"""The world: the simulation with all its parts, and the stages of one simulation step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

from simx_server.kinematics import IkGroups
from simx_server.kinematics.planning.motion_plannings import MotionPlannings
from simx_server.kinematics.planning.path_plannings import PathPlannings
from simx_server.limits import Limits
from simx_server.parts.clouds.clouds import PointClouds
from simx_server.parts.communication.ros2_topics import Ros2Topics
from simx_server.parts.communication.script_ports import ScriptPorts
from simx_server.parts.communication.signals import Signals
from simx_server.parts.communication.simulator_messages import SimulatorMessages
from simx_server.parts.communication.tubes import Tubes
from simx_server.parts.communication.wireless import Wireless
from simx_server.parts.custom_data import CustomData
from simx_server.parts.drawing import DrawingObjects
from simx_server.parts.dummy_links import DummyLinks
from simx_server.parts.graphs import Graphs
from simx_server.parts.object_settings import ObjectSettings
from simx_server.parts.parameters import Parameters
from simx_server.parts.particles import Particles
from simx_server.parts.paths.paths import Paths
from simx_server.parts.selection import Selection
from simx_server.parts.shape_colors import ShapeColors
from simx_server.parts.status_bar import StatusBar
from simx_server.parts.textures.textures import Textures
from simx_server.parts.user_interface import UserInterface
from simx_server.parts.written_files import WrittenFiles
from simx_server.scene.collection import Collections
from simx_server.scene.trial.trials import Trials
from simx_server.scripting import Scripts
from simx_server.scripting.script_parameters import ScriptParameters
from simx_server.sensors.distance.meters import Meters
from simx_server.sensors.force import ForceSensors
from simx_server.sensors.instant import Instants
from simx_server.sensors.proximity.proximity import ProximitySensors
from simx_server.sensors.vision.render_thread import RenderThread
from simx_server.sensors.vision.vision_sensors import VisionSensors
from simx_server.simulation.applied_forces import AppliedForces
from simx_server.simulation.simulation import Simulation, SimulationState
from simx_server.simulation.velocities import Velocities

Action = Callable[[], object]

Stage = tuple[str, Callable[["World"], Action]]
"""A name, and a function that returns what a world does in this stage."""


@dataclass(frozen=True, slots=True)
class World:
    """All parts, made by `building.build_world`. Physics thread only, except `rendering`."""

    simulation: Simulation
    velocities: Velocities
    applied_forces: AppliedForces
    signals: Signals
    status_bar: StatusBar
    selection: Selection
    simulator_messages: SimulatorMessages
    custom_data: CustomData
    object_settings: ObjectSettings
    shape_colors: ShapeColors
    dummy_links: DummyLinks
    collections: Collections
    instants: Instants
    meters: Meters
    proximity: ProximitySensors
    force: ForceSensors
    rendering: RenderThread
    vision: VisionSensors
    tubes: Tubes
    wireless: Wireless
    script_parameters: ScriptParameters
    script_ports: ScriptPorts
    written_files: WrittenFiles
    ros2_topics: Ros2Topics
    scripts: Scripts
    ik_groups: IkGroups
    path_plannings: PathPlannings
    motion_plannings: MotionPlannings
    paths: Paths
    clouds: PointClouds
    textures: Textures
    drawings: DrawingObjects
    particles: Particles
    graphs: Graphs
    trials: Trials
    user_interface: UserInterface
    parameters: Parameters

    STEP: ClassVar[tuple[Stage, ...]] = (
        ("scripts' actuation", lambda world: world.scripts.actuate),
        ("paths", lambda world: world.paths.move),
        ("inverse kinematics", lambda world: world.ik_groups.handle_automatic),
        ("first velocities of placed shapes", lambda world: world.object_settings.launch_placed),
        ("surfaces that move", lambda world: world.simulation.surfaces.prepare),
        ("physics with joint controllers", lambda world: world.simulation.run_physics),
        ("moved surfaces arrive", lambda world: world.simulation.surfaces.finish),
        ("applied forces end", lambda world: world.applied_forces.clear),
        ("velocities of objects", lambda world: world.velocities.store),
        ("velocities of joints", lambda world: world.simulation.measure_joints),
        ("meshes of changed point clouds", lambda world: world.clouds.show),
        ("textures that scripts wrote", lambda world: world.textures.show),
        ("collisions and distances", lambda world: world.meters.sense),
        ("proximity sensors", lambda world: world.proximity.sense),
        ("force sensors", lambda world: world.force.sense),
        ("vision sensors", lambda world: world.vision.sense_all),
        ("images that scripts judge", lambda world: world.scripts.judge_images),
        ("scripts' sensing", lambda world: world.scripts.sense),
        ("graphs", lambda world: world.graphs.record_all),
        ("time", lambda world: world.simulation.count_step),
    )
    """The stages of a simulation step, in the order of V-REP's main script. Other images are rendered on request."""

    _step: tuple[Action, ...] = field(init=False, repr=False)
    """The stages of this world: a small step spends much of its time on reaching them."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "_step", tuple(stage(self) for _, stage in self.STEP))

    @property
    def limits(self) -> Limits:
        """Return how much clients may make the server hold."""
        return self.simulation.limits

    def step(self) -> None:
        """Make one simulation step if the simulation runs. When physics cannot continue, the run is stopped."""
        simulation = self.simulation
        running = SimulationState.RUNNING
        for stage in self._step:
            if simulation.state is not running:
                return
            stage()
        simulation.settle()

    def idle(self) -> None:
        """Do regular work; to be called from time to time while stopped or paused."""
        self.scripts.idle()
        self.clouds.show()
        self.textures.show()
        self.simulation.settle()
