"""Motors as V-REP's physics engines have them: a joint keeps the commanded velocity with a limited force.

MuJoCo has this constraint, and solves it together with contacts and couplings: the friction loss of a joint or tendon
keeps its velocity at 0 with at most that force. A motor is the same constraint with a moving reference, the
acceleration (command - velocity) / physics step: so the velocity at the end of the step is the command. No gain has to
be chosen, the motor carries any load up to its maximum force, and a stalled motor presses with exactly this force.

The command is the control of the joint's actuator, whose gain is 0; the maximum force is the friction loss in the
model. Both are MuJoCo's own state, so that a C function could do the same within a plain `mj_step`: MuJoCo calls
`mjcb_control` when the reference accelerations are known.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.joints.guards.watch import StepFailed
from simx_server.joints.servo import Entry, is_motor

from .indices import Columns, as_slice

Step = Callable[[mujoco.MjModel, mujoco.MjData], None]
"""Makes one physics step."""

_ROW_TYPES = {
    "joint": int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF),
    "tendon": int(mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON),
}


def no_room(data: mujoco.MjData) -> StepFailed:
    """Return the reason why a motor has no constraint."""
    return StepFailed(
        f"MuJoCo's memory ({data.narena} bytes) has no room for the constraints of {data.ncon} contacts, so "
        "motors would do nothing: have fewer contacts, or a larger <size memory=...> in the scene"
    )


class Motors:
    """The motors of one model and its data, in arrays."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entries: Sequence[Entry]) -> None:
        """Find the motors; the force limits in the model may change later, but not which joints have friction loss."""
        bindings = [binding for binding, state, rule in entries if is_motor(binding, state, rule)]
        bindings.sort(key=lambda b: (b.element == "tendon", b.dof, b.id))  # MuJoCo's order of constraints
        self._bindings = bindings
        dofs, tendons = (
            np.flatnonzero(model.dof_frictionloss > 0),
            np.flatnonzero(model.tendon_frictionloss > 0),
        )
        self._rows_in_all = len(dofs) + len(tendons)
        rows = [
            len(dofs) + np.searchsorted(tendons, b.id)
            if b.element == "tendon"
            else np.searchsorted(dofs, b.dof)
            for b in bindings
        ]
        self._rows = np.array(rows, dtype=np.intp)
        self._with_friction = [(place, b) for place, b in enumerate(bindings) if b.friction > 0]
        self._stuck: list[int] = []
        self._wanted = np.zeros(len(bindings))
        self._command = self._commanding(data)
        self._report = self._reporting(data)
        self._rate = 1.0 / model.opt.timestep

    def __bool__(self) -> bool:
        return bool(self._bindings)

    @property
    def columns(self) -> Columns:
        """Return the arrays by name, for the compiled form."""
        bindings, frictions = self._bindings, self._with_friction
        return {
            "motor.ctrl": np.array([b.ctrl for b in bindings], dtype=np.intp),
            "motor.out": np.array([b.out for b in bindings], dtype=np.intp),
            "motor.gear": np.array([b.gear for b in bindings]),
            "motor.row": self._rows,
            "motor.dof": np.array([b.dof for b in bindings if b.element == "joint"], dtype=np.intp),
            "motor.tendon": np.array([b.id for b in bindings if b.element == "tendon"], dtype=np.intp),
            "friction.place": np.array([place for place, _ in frictions], dtype=np.intp),
            "friction.actuator": np.array([b.actuator for _, b in frictions], dtype=np.intp),
            "friction.loss": np.array([b.friction for _, b in frictions]),
        }

    @property
    def rows_in_all(self) -> int:
        """Return the number of MuJoCo's constraints for friction loss while no body sleeps."""
        return self._rows_in_all

    def stepped(self, within: Sequence[Callable[[mujoco.MjModel, mujoco.MjData], Any]]) -> Step:
        """Return what makes a physics step with these motors.

        Args:
            within: called within the step, when MuJoCo's constraints are known.
        """
        first_half, second_half = mujoco.mj_step1, mujoco.mj_step2
        command, report, wanted, rate = self._command, self._report, self._wanted, self._rate
        multiply = np.multiply
        with_friction, count = self._with_friction, self._rows_in_all
        adjacent = as_slice(self._rows)

        def step(model: mujoco.MjModel, data: mujoco.MjData) -> None:
            if with_friction:
                self._resist(model, data)
            first_half(model, data)
            for call in within:
                call(model, data)
            command()
            multiply(wanted, rate, wanted)
            first = data.ne
            if data.nf != count:
                rows = self._awake_rows(data)
            elif adjacent is None:
                rows = self._rows + first
            else:
                rows = slice(adjacent.start + first, adjacent.stop + first)
            data.efc_aref[rows] = wanted
            second_half(model, data)
            report(data.efc_force[rows])

        return step

    def _awake_rows(self, data: mujoco.MjData) -> NDArray[np.intp]:
        """Return the rows of the motors where those of sleeping bodies are missing. A body with a motor is awake.

        Raises:
            StepFailed: the model's memory has no room for all constraints; MuJoCo goes on without the rest.
        """
        first, last = data.ne, data.ne + data.nf
        kinds, ids = data.efc_type[first:last].tolist(), data.efc_id[first:last].tolist()
        present = {key: first + row for row, key in enumerate(zip(kinds, ids, strict=True))}
        rows = [
            present.get((_ROW_TYPES[b.element], b.dof if b.element == "joint" else b.id))
            for b in self._bindings
        ]
        if None in rows:
            raise no_room(data)
        return np.array(rows, dtype=np.intp)

    def _commanding(self, data: mujoco.MjData) -> Callable[[], object]:
        """Return what writes the difference of each motor's command from its velocity, rad/s or m/s."""
        wanted, bindings = self._wanted, self._bindings
        ctrl = np.array([b.ctrl for b in bindings], dtype=np.intp)
        dofs = np.array([b.dof for b in bindings if b.element == "joint"], dtype=np.intp)
        tendons = np.array([b.id for b in bindings if b.element == "tendon"], dtype=np.intp)
        gear = np.array([b.gear for b in bindings])
        subtract = np.subtract
        of_ctrl, of_dofs = as_slice(ctrl), as_slice(dofs)
        if of_ctrl is not None and of_dofs is not None and not tendons.size and np.all(gear == 1.0):
            commands, velocities = data.ctrl[of_ctrl], data.qvel[of_dofs]
            if not self._with_friction:
                return lambda: subtract(commands, velocities, wanted)
        controls, speeds, lengthening = data.ctrl, data.qvel, data.ten_velocity
        velocity = np.zeros(len(bindings))
        of_joints, of_tendons = velocity[: len(dofs)], velocity[len(dofs) :]

        def command() -> None:
            controls.take(ctrl, out=wanted, mode="clip")
            np.divide(wanted, gear, wanted)
            if self._stuck:
                wanted[self._stuck] = 0.0
            speeds.take(dofs, out=of_joints, mode="clip")
            if tendons.size:
                lengthening.take(tendons, out=of_tendons, mode="clip")
            subtract(wanted, velocity, wanted)

        return command

    def _reporting(self, data: mujoco.MjData) -> Callable[[NDArray[np.float64]], object]:
        """Return what writes the forces where MuJoCo keeps those of actuators, which it computes in each step."""
        out = np.array([b.out for b in self._bindings], dtype=np.intp)
        gear = np.array([b.gear for b in self._bindings])
        forces, adjacent = data.actuator_force, as_slice(out)
        if adjacent is not None and np.all(gear == 1.0):
            place = forces[adjacent]
            return lambda force: np.copyto(place, force)
        return lambda force: forces.__setitem__(out, force / gear)

    def _resist(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Let the friction of the joints themselves act against the commanded motion.

        Their constraint is the motor's now, so the friction becomes a force of the actuator. A motor that is weaker
        than the friction moves nothing: then the constraint has the force of the friction, see `write_motor_force`.
        """
        self._stuck = []
        for place, binding in self._with_friction:
            tendon = binding.element == "tendon"
            most = model.tendon_frictionloss[binding.id] if tendon else model.dof_frictionloss[binding.dof]
            resistance = binding.friction * np.sign(data.ctrl[binding.ctrl] * binding.gear)
            if most <= binding.friction:
                self._stuck.append(place)
                resistance = 0.0
            model.actuator_biasprm[binding.actuator, 0] = -resistance / binding.gear
