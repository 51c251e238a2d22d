"""The state of each joint: its place in the model, V-REP's settings of it, and their initial values.

An annotation has V-REP's strict meaning. Without one: a joint with a position actuator is a spring and damper with
that actuator's gains, and holds where it is; with a velocity actuator it is under velocity control at 0, with that
actuator's gain; with a torque motor or none its motor is off until a target drives it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from enum import IntEnum
from operator import attrgetter

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.motion_profiles import Profile
from simx_server.scene.dependencies import EQUALITY
from simx_server.scene.formats.annotations import Annotation, numbers_of
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.poses import Quaternion
from simx_server.scene.tree import drives_tendon

VREP_DYNAMICS_STEP = 0.005
"""V-REP's dynamics step in seconds. V-REP's PID divides by it, whatever step the physics engine uses."""

UNLIMITED = 1e9
"""Force in N or N m that stands for a joint without a force limit."""

UPPER_VELOCITY = {"hinge": 2 * math.pi, "slide": 10.0}
"""V-REP's initial upper velocities, rad/s and m/s."""


class JointMode(IntEnum):
    """The legacy `sim_jointmode_*` numbers."""

    PASSIVE = 0
    MOTION = 1
    IK = 2
    IK_DEPENDENT = 3
    DEPENDENT = 4
    FORCE = 5


class Native(IntEnum):
    """The kind of actuator that the joint has in the file."""

    NONE = 0
    POSITION = 1
    VELOCITY = 2
    MOTOR = 3


MODE_WORDS = {
    "force": JointMode.FORCE,
    "passive": JointMode.PASSIVE,
    "ik": JointMode.IK,
    "ik_dependent": JointMode.IK_DEPENDENT,
    "dependent": JointMode.DEPENDENT,
    "motion": JointMode.MOTION,
}


@dataclass(slots=True)
class Binding:
    """Where a joint is in one compiled model; -1: absent."""

    handle: int
    name: str
    element: str
    kind: str
    """hinge, slide or ball; a tendon counts as slide."""
    id: int
    body: int
    qpos: int
    dof: int
    actuator: int
    ctrl: int
    out: int
    gear: float
    native: Native
    gain: tuple[float, ...]
    bias: tuple[float, ...]
    bias_type: int
    gain_type: int
    ctrl_limited: bool
    force_limited: bool
    force_range: tuple[float, float]
    force_limit: float
    """The file's limit at the joint, UNLIMITED for none."""
    friction: float
    """The file's friction loss, N m or N."""
    friction_impedance: tuple[float, ...]
    """`solimp` of that friction."""
    inertia: float
    """The least inertia that the motor feels, kg m^2 or kg: that with all other joints free."""
    gravcomp: float
    equality: int
    """The equality that couples a joint of dependent mode to its master."""

    @property
    def qpos_count(self) -> int:
        """Return the number of position values: 4 for a spherical joint, else 1."""
        return 4 if self.kind == "ball" else 1

    @property
    def dof_count(self) -> int:
        """Return the degrees of freedom: 3 for a spherical joint, else 1."""
        return 3 if self.kind == "ball" else 1

    def reported_force(self, model: mujoco.MjModel, actuator_forces: np.ndarray) -> float:
        """Return the motor's force (N) or torque (N m) at the joint with V-REP's sign.

        V-REP reports the reverse of what the motor applies to the child along the joint's +z.

        Args:
            model: The model that the binding belongs to; a force limit of the joint itself counts.
            actuator_forces: Forces at the actuators, as `MjData.actuator_force`.
        """
        force = float(actuator_forces[self.out]) * self.gear
        if self.element == "joint" and model.jnt_actfrclimited[self.id]:
            low, high = model.jnt_actfrcrange[self.id].tolist()
            force = min(max(force, low), high)
        return 0.0 - force  # never -0.0

    @property
    def file_spring(self) -> tuple[float, float]:
        """Return K and C, at the joint, of the file's position actuator."""
        gear = self.gear * self.gear
        return self.gain[0] * gear, -self.bias[2] * gear


@dataclass(frozen=True, slots=True)
class Request:
    """A target to which a script's call-back moves a kinematic joint; positions in rad or m, and their rates."""

    position: float | None
    """None: only the velocity counts."""
    velocity: float = 0.0
    present_velocity: float = 0.0
    present_acceleration: float = 0.0
    """The motion at the last call, as the script gave it."""

    def going_on(self, velocity: float, acceleration: float) -> Request:
        """Return the request for the next call."""
        return replace(self, present_velocity=velocity, present_acceleration=acceleration)


@dataclass(slots=True)
class JointState:
    """V-REP's settings of one joint."""

    annotated: bool
    """Whether targets leave motor and control loop as they are; if not, the last target sets them."""
    mode: JointMode
    motor: bool
    control_loop: bool
    spring: bool
    """The control loop is a spring and damper instead of V-REP's position controller."""
    lock: bool
    p: float
    i: float
    d: float
    k: float
    c: float
    upper_velocity: float
    max_force: float
    target_position: float
    target_velocity: float
    cyclic: bool
    acceleration: float = 0.0
    """Greatest acceleration of motion profiles; 0: none is known, and a target outside force mode moves nothing."""
    jerk: float = 0.0
    """Greatest jerk of motion profiles; 0: no limit."""
    motion: Profile | None = None
    """The profile by which the joint moves outside force mode, of the position in the model."""
    motion_time: float = 0.0
    """Seconds since the start of that motion."""
    pushes: int = 0
    """With the motor on and the control loop off: 1 or -1 where the motor acts with its maximum force, towards greater
    or smaller positions, whatever its target velocity (V-REP's force control); 0: velocity control."""
    backwards: bool = False
    """The maximum force was given as a negative number; the sign of a target velocity other than 0 replaces it."""
    hybrid: bool = False
    """Outside force mode: a motor drives the joint to where it is set."""
    master: int = -1
    """Handle of the joint that a dependent joint follows."""
    factor: float = 1.0
    shift: float = 0.0
    """Position = shift + factor * master's position."""
    scripted: bool = False
    """The position controller is a script's (CoppeliaSim's custom control)."""
    request: Request | None = None
    """The target outside force mode to which a script's call-back moves the joint."""
    rewind: bool = False
    """After each physics step an undriven joint is put back to its position in the file, and keeps its velocity."""
    inert: bool = False
    """Held where it is, in any mode, because the joint belongs to a model that is not dynamic."""
    rigid: bool = True
    """V-REP's motor drives the joint; False: the servo of the file's velocity actuator, with its gain."""
    fixed: bool = False
    """Held where it is, in any mode, because the file says that physics does not move it."""
    spherical: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """x, y, z of a spherical joint's next quaternion, which is applied when w is written."""
    alignment: Quaternion | None = None
    """The rotation from the body's axes to the joint's, when something was placed against the joint."""
    ik_weight: float = 1.0
    """How readily inverse kinematics moves the joint, beside the others."""
    motor_was_set: bool = False
    """Set by an annotation or a caller; only then does switching the motor off remove the gravity compensation."""
    offset: float = 0.0
    held: float = 0.0
    """The position that a joint locked in velocity control holds."""


def bind(item: SceneObject, model: mujoco.MjModel) -> Binding:
    """Return a joint object's addresses and its actuator in the model, with the settings from the file."""
    tendon = item.element == "tendon"
    kind = "slide"
    qpos = dof = -1
    if not tendon:
        kind = {0: "free", 1: "ball", 2: "slide", 3: "hinge"}[int(model.jnt_type[item.id])]
        qpos, dof = int(model.jnt_qposadr[item.id]), int(model.jnt_dofadr[item.id])
    actuator = _find_actuator(item, model) if kind != "ball" else -1
    driven = actuator >= 0
    native = _native(model, actuator) if driven else Native.NONE
    gear = float(model.actuator_gear[actuator, 0]) if driven else 1.0
    friction, friction_impedance = _friction(item, model, dof)
    binding = Binding(
        handle=item.handle,
        name=item.name,
        element=item.element,
        kind=kind,
        id=item.id,
        body=item.body,
        qpos=qpos,
        dof=dof,
        actuator=actuator,
        ctrl=int(model.actuator_ctrladr[actuator]) if driven else -1,
        out=int(model.actuator_outadr[actuator]) if driven else -1,
        gear=gear,
        native=native,
        gain=tuple(model.actuator_gainprm[actuator].tolist()) if driven else (),
        bias=tuple(model.actuator_biasprm[actuator].tolist()) if driven else (),
        bias_type=int(model.actuator_biastype[actuator]) if driven else 0,
        gain_type=int(model.actuator_gaintype[actuator]) if driven else 0,
        ctrl_limited=bool(model.actuator_ctrllimited[actuator]) if driven else False,
        force_limited=bool(model.actuator_forcelimited[actuator]) if driven else False,
        force_range=tuple(model.actuator_forcerange[actuator].tolist()) if driven else (0.0, 0.0),
        force_limit=UNLIMITED,
        friction=friction,
        friction_impedance=friction_impedance,
        inertia=_inertia(model, dof),
        gravcomp=float(model.body_gravcomp[item.body]),
        equality=_find_equality(item, model),
    )
    binding.force_limit = _force_limit(binding, model)
    return binding


def _inertia(model: mujoco.MjModel, dof: int) -> float:
    """Return the least inertia of a joint; infinite for a tendon and for a joint that nothing moves."""
    inverse = float(model.dof_invweight0[dof]) if dof >= 0 else 0.0
    return 1.0 / inverse if inverse > 0 else math.inf


SETTING_NAMES = tuple(each.name for each in fields(JointState))

setting_values = attrgetter(*SETTING_NAMES)
"""Return all values of a `JointState`, in the order of `SETTING_NAMES`."""


def copied(state: JointState) -> JointState:
    """Return a copy of the settings; `dataclasses.replace` takes ten times as long."""
    return JointState(*setting_values(state))


def initial_state(
    item: SceneObject, binding: Binding, model: mujoco.MjModel, position: float, joints: Mapping[str, int]
) -> JointState:
    """Return the settings that a joint starts with.

    Args:
        item: the joint.
        binding: where it is in the model.
        model: the compiled model.
        position: its present position.
        joints: handles by MuJoCo's names.
    """
    found = item.annotations.get("joint")
    annotated = found is not None
    note: Annotation = found or {}
    native = binding.native
    control = note.get("control", "spring" if native == Native.POSITION and not annotated else None)
    max_force = float(note.get("max_force", binding.force_limit))
    loop = control in ("position", "spring", "script") if control is not None else native == Native.POSITION
    k, c = binding.file_spring if native == Native.POSITION else (0.1, 0.0)
    cyclic_by_file = binding.kind == "hinge" and not model.jnt_limited[binding.id]
    # The key is a shift of the reported value for a tendon, but the constant of the dependency for a joint.
    offset = float(note.get("offset", 0.0))
    shift = 0.0
    if binding.element != "tendon":
        offset, shift = shift, offset
    position += offset
    return JointState(
        annotated=annotated and not note.get("switches", False),
        mode=MODE_WORDS[str(note.get("mode", "force"))],
        motor=bool(note.get("motor", native in (Native.POSITION, Native.VELOCITY))),
        control_loop=loop,
        spring=control == "spring" or bool(note.get("spring", False)),
        scripted=control == "script",
        lock=bool(note.get("lock", False)),
        p=float(note.get("P", 0.1)),
        i=float(note.get("I", 0.0)),
        d=float(note.get("D", 0.0)),
        k=float(note.get("K", k)),
        c=float(note.get("C", c)),
        upper_velocity=float(note.get("upper_velocity", UPPER_VELOCITY.get(binding.kind, 0.0))),
        acceleration=float(note.get("upper_acceleration", 0.0)),
        jerk=float(note.get("upper_jerk", 0.0)),
        pushes=0 if control != "force" else -1 if max_force < 0 else 1,
        backwards=max_force < 0,
        max_force=abs(max_force),
        target_position=float(note.get("target_position", position)),
        target_velocity=float(note.get("target_velocity", 0.0)),
        cyclic=bool(note.get("cyclic", cyclic_by_file)),
        hybrid=bool(note.get("hybrid", False)),
        rewind=bool(note.get("rewind", False)),
        rigid=native != Native.VELOCITY or bool(note.get("rigid", annotated)),
        fixed=bool(note.get("fixed", False)),
        alignment=_alignment(note),
        ik_weight=float(note.get("ik_weight", 1.0)),
        master=joints.get(str(note["master"]), -1) if "master" in note else -1,
        factor=float(note.get("multiplication", 1.0)),
        shift=shift,
        motor_was_set="motor" in note,
        offset=offset,
        held=position,
    )


def _alignment(note: Annotation) -> Quaternion | None:
    if "alignment" not in note:
        return None
    w, x, y, z = numbers_of(note["alignment"])
    return w, x, y, z


def _find_actuator(item: SceneObject, model: mujoco.MjModel) -> int:
    """Return the first actuator of the joint whose gain and bias may be rewritten, or -1."""
    if item.element == "tendon":
        return next(
            (a for a in range(model.nu) if model.actuator_trnid[a, 0] == item.id and drives_tendon(model, a)),
            -1,
        )
    joint_drives = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    for actuator in range(model.nu):
        if (
            int(model.actuator_trntype[actuator]) in joint_drives
            and model.actuator_trnid[actuator, 0] == item.id
            and model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE.value
            and model.actuator_gaintype[actuator] == mujoco.mjtGain.mjGAIN_FIXED.value
            and model.actuator_biastype[actuator] <= int(mujoco.mjtBias.mjBIAS_AFFINE)
            and model.actuator_gear[actuator, 0] != 0
            and model.actuator_ctrlnum[actuator] == 1
        ):
            return actuator
    return -1


def _find_equality(item: SceneObject, model: mujoco.MjModel) -> int:
    """Return the equality that loading added for the joint, or -1; the name of a copy's equality has a prefix."""
    if item.element != "joint":
        return -1
    of_joint = (model.eq_type == mujoco.mjtEq.mjEQ_JOINT.value) & (model.eq_obj1id == item.id)
    found = np.nonzero(of_joint)[0].tolist()
    return next((equality for equality in found if EQUALITY in model.equality(equality).name), -1)


def _native(model: mujoco.MjModel, actuator: int) -> Native:
    gain = float(model.actuator_gainprm[actuator, 0])
    constant, stiffness, damping = model.actuator_biasprm[actuator, :3].tolist()
    if (
        model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_AFFINE.value
        and constant == 0.0
        and gain > 0
    ):
        if stiffness == -gain:
            return Native.POSITION
        if stiffness == 0.0 and damping == -gain:
            return Native.VELOCITY
    return Native.MOTOR


def _friction(item: SceneObject, model: mujoco.MjModel, dof: int) -> tuple[float, tuple[float, ...]]:
    """Return the file's friction loss of a joint or tendon, and its `solimp`."""
    if item.element == "tendon":
        return float(model.tendon_frictionloss[item.id]), tuple(model.tendon_solimp_fri[item.id].tolist())
    return float(model.dof_frictionloss[dof]), tuple(model.dof_solimp[dof].tolist())


def _force_limit(binding: Binding, model: mujoco.MjModel) -> float:
    """Return the file's limit at the joint: of the actuator, of a motor's control range, of the joint."""
    limits = [UNLIMITED]
    if binding.actuator >= 0:
        gear = abs(binding.gear)
        if binding.force_limited:
            limits.append(max(abs(v) for v in binding.force_range) * gear)
        if binding.native == Native.MOTOR and binding.ctrl_limited and binding.gain[0]:
            limits.append(
                float(max(abs(model.actuator_ctrlrange[binding.actuator]))) * abs(binding.gain[0]) * gear
            )
    if binding.element == "joint" and model.jnt_actfrclimited[binding.id]:
        limits.append(float(max(abs(model.jnt_actfrcrange[binding.id]))))
    return min(limits)
