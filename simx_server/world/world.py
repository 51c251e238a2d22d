"""The world: the simulation with all its parts, and the stages of one simulation step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from typing import ClassVar, Literal

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.joints.stepping.apart import Stepping
from simx_server.kinematics import IkGroups
from simx_server.kinematics.planning.scene_tasks.motion_plannings import MotionPlannings
from simx_server.kinematics.planning.scene_tasks.path_plannings import PathPlannings
from simx_server.kinematics.searching import Searching
from simx_server.limits import Limits
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
from simx_server.parts.user_interface.interface import UserInterface
from simx_server.parts.written_files import WrittenFiles
from simx_server.scene.collection import Collections
from simx_server.scene.formats.kept_models import KeptModels
from simx_server.scene.trial.trials import Trials
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
from simx_server.simulation.simulation import Simulation, SimulationState
from simx_server.simulation.surfaces import Surfaces
from simx_server.simulation.velocities import Velocities
from simx_server.teleoperation.arm_drive import ArmDrive

Action = Callable[[], object]

Stage = tuple[str, Callable[["World"], Action | Literal[False]]]
"""A name, and a function that returns what a world does in this stage; False: nothing, until `Parts.replan`."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class World:
    """All parts, made by `building.build_world`. Physics thread only, except `rendering`."""

    simulation: Simulation
    physics: Physics
    surfaces: Surfaces
    velocities: Velocities
    applied_forces: AppliedForces
    signals: Signals
    status_bar: StatusBar
    selection: Selection
    simulator_messages: SimulatorMessages
    custom_data: CustomData
    object_settings: ObjectSettings
    origins: Origins
    shape_colors: ShapeColors
    dummy_links: DummyLinks
    collections: Collections
    instants: Instants
    meters: Meters
    proximity: ProximitySensors
    force: ForceSensors
    contacts: Contacts
    rendering: RenderThread
    vision: VisionSensors
    tubes: Tubes
    wireless: Wireless
    semaphores: Semaphores
    outside: Outside
    serial_ports: SerialPorts
    programs: Programs
    script_parameters: ScriptParameters
    script_ports: ScriptPorts
    written_files: WrittenFiles
    ros2_topics: Ros2Topics
    scripts: Scripts
    searching: Searching
    ik_groups: IkGroups
    arm_drive: ArmDrive
    path_plannings: PathPlannings
    motion_plannings: MotionPlannings
    paths: Paths
    clouds: PointClouds
    textures: Textures
    drawings: DrawingObjects
    instances: Instances
    particles: Particles
    plugin_infos: PluginInfos
    graphs: Graphs
    trials: Trials
    kept_models: KeptModels
    user_interface: UserInterface
    parameters: Parameters
    another: Callable[[], World]
    """Makes another world of the same kind, with the empty scene; it shares the render thread."""

    STEP: ClassVar[tuple[Stage, ...]] = (
        ("teleoperation", lambda world: world.arm_drive.has_work and world.arm_drive.move),
        ("scripts' actuation", lambda world: world.scripts.phases.has_work and world.scripts.phases.actuate),
        ("paths", lambda world: world.paths.has_work and world.paths.move),
        ("inverse kinematics", lambda world: world.ik_groups.has_work and world.ik_groups.handle_automatic),
        ("edits that wait", lambda world: world.simulation.compile_edits),
        (
            "first velocities of placed shapes",
            lambda world: world.object_settings.has_work and world.object_settings.launch_placed,
        ),
        (
            "surfaces that move",
            lambda world: world.surfaces.has_work and world.surfaces.prepare,
        ),
        ("physics with joint controllers", lambda world: world.physics.run),
        (
            "moved surfaces arrive",
            lambda world: world.surfaces.has_work and world.surfaces.finish,
        ),
        ("particles", lambda world: world.particles.has_work and world.particles.move),
        ("applied forces end", lambda world: world.applied_forces.has_work and world.applied_forces.clear),
        ("velocities of objects", lambda world: world.velocities.store),
        ("velocities of joints", lambda world: world.simulation.measure_joints),
        ("meshes of changed point clouds", lambda world: world.clouds.has_work and world.clouds.show),
        ("textures that scripts wrote", lambda world: world.textures.has_work and world.textures.show),
        ("collisions and distances", lambda world: world.meters.has_work and world.meters.sense),
        ("proximity sensors", lambda world: world.proximity.has_work and world.proximity.sense),
        ("force sensors", lambda world: world.force.has_work and world.force.sense),
        ("vision sensors", lambda world: world.vision.has_work and world.vision.sense_all),
        (
            "images that scripts judge",
            lambda world: world.scripts.phases.judges and world.scripts.phases.judge_images,
        ),
        ("scripts' sensing", lambda world: world.scripts.phases.senses and world.scripts.phases.sense),
        ("graphs", lambda world: world.graphs.has_work and world.graphs.record_all),
        ("time", lambda world: world.simulation.count_step),
    )
    """The stages of a simulation step, in the order of V-REP's main script. Other images are rendered on request."""

    stages: list[tuple[int, Action]] = field(init=False, repr=False)
    """What `find_stages` found when `Parts.replan` was called last; belongs to `step`."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "stages", [])

    @property
    def limits(self) -> Limits:
        """Return how much clients may make the server hold."""
        return self.simulation.limits

    def step(self) -> None:
        """Make one simulation step if the simulation runs and no script refuses it. When physics cannot continue, the
        run is stopped.
        """
        simulation, running, done = self.simulation, SimulationState.RUNNING, -1
        if simulation.state is running and self.scripts.phases.refuse_step():
            simulation.settle()
            return
        while done < len(self.STEP) - 1:
            for number, act in self._stages_after(done):
                if simulation.state is not running:
                    return
                act()
                done = number
                if simulation.parts.are_stages_stale:
                    break
        simulation.settle()

    def step_apart(self) -> Stepping:
        """Make one simulation step as `step`; where its physics needs no Python, the caller makes that at a yield."""
        simulation, running, done = self.simulation, SimulationState.RUNNING, -1
        if simulation.state is running and self.scripts.phases.refuse_step():
            simulation.settle()
            return
        while done < len(self.STEP) - 1:
            for number, act in self._stages_after(done):
                if simulation.state is not running:
                    return
                if number == _PHYSICS:
                    yield from self.physics.run_apart()
                else:
                    act()
                done = number
                if simulation.parts.are_stages_stale:
                    break
        simulation.settle()

    def finish_step(self, physics: Callable[[], object]) -> None:
        """Make the rest of a simulation step whose physics was not made by `step`.

        Args:
            physics: makes what is left of the physics.
        """
        simulation = self.simulation
        for number, act in self._stages_after(_PHYSICS - 1):
            if simulation.state is not SimulationState.RUNNING:
                return
            (physics if number == _PHYSICS else act)()
        simulation.settle()

    @property
    def is_only_physics(self) -> bool:
        """Return whether a simulation step consists of physics, and of what follows from positions alone."""
        other = {number for number, _ in self._stages_after(-1)} - _PLAIN
        return not other or (other == {_VISION} and not self.vision.remembers)

    def _stages_after(self, done: int) -> Sequence[tuple[int, Action]]:
        """Return what is left of a simulation step; a stage may give a later one something to do."""
        if self.simulation.parts.are_stages_stale:
            self.simulation.parts.stages_listed()
            self.stages[:] = self.find_stages()
        return self.stages if done < 0 else [each for each in self.stages if each[0] > done]

    def find_stages(self) -> list[tuple[int, Action]]:
        """Return what there is to do in a simulation step now, with the numbers of the stages in `STEP`."""
        found = ((number, find(self)) for number, (_, find) in enumerate(self.STEP))
        return [(number, act) for number, act in found if callable(act)]

    def idle(self) -> None:
        """Do regular work; to be called from time to time while stopped or paused."""
        self.scripts.phases.idle()
        self.clouds.show()
        self.textures.show()
        self.simulation.settle()


_PHYSICS = next(number for number, (name, _) in enumerate(World.STEP) if name.startswith("physics"))

_VISION = next(number for number, (name, _) in enumerate(World.STEP) if name == "vision sensors")
"""Without filters that remember images, this stage notes in a run's first step that it was there."""

_PLAIN = frozenset(
    number
    for number, (name, _) in enumerate(World.STEP)
    if number == _PHYSICS
    or name
    in (
        "edits that wait",
        "surfaces that move",
        "moved surfaces arrive",
        "velocities of objects",
        "velocities of joints",
        "time",
    )
)
"""Stages that have nothing to do where nothing was moved or edited, or that follow from positions."""
