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

from simx_server.joints.grip import Grip
from simx_server.joints.servo import MOST_VELOCITY, Entry, is_motor

Step = Callable[[mujoco.MjModel, mujoco.MjData], None]
"""Makes one physics step."""

_ROW_TYPES = {
    "joint": int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF),
    "tendon": int(mujoco.mjtConstraint.mjCNSTR_FRICTION_TENDON),
}


class Motors:
    """The motors of one model and its data, in arrays."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entries: Sequence[Entry]) -> None:
        """Find the motors; the force limits in the model may change later, but not which joints have friction loss."""
        bindings = [binding for binding, state, rule in entries if is_motor(binding, state, rule)]
        bindings.sort(key=lambda b: (b.element == "tendon", b.dof, b.id))  # MuJoCo's order of constraints
        self._bindings = bindings
        self._model, self._data = model, data
        dofs, tendons = (
            np.flatnonzero(model.dof_frictionloss > 0),
            np.flatnonzero(model.tendon_frictionloss > 0),
        )
        self._rows_in_all = len(dofs) + len(tendons)
        self._rows = np.array(
            [
                len(dofs) + np.searchsorted(tendons, b.id)
                if b.element == "tendon"
                else np.searchsorted(dofs, b.dof)
                for b in bindings
            ],
            dtype=np.intp,
        )
        self._ctrl = np.array([b.ctrl for b in bindings], dtype=np.intp)
        self._out = np.array([b.out for b in bindings], dtype=np.intp)
        self._gear = np.array([b.gear for b in bindings])
        self._has_gear = bool(np.any(self._gear != 1.0))
        joints = [b.dof for b in bindings if b.element == "joint"]
        self._dofs = np.array(joints, dtype=np.intp)
        self._tendons = np.array([b.id for b in bindings if b.element == "tendon"], dtype=np.intp)
        self._velocity = np.zeros(len(bindings))
        self._of_joints, self._of_tendons = self._velocity[: len(joints)], self._velocity[len(joints) :]
        self._wanted = np.zeros(len(bindings))
        self._with_friction = [b for b in bindings if b.friction > 0]
        self._grip = Grip(model)

    def __bool__(self) -> bool:
        return bool(self._bindings)

    def stepped(self, within: Callable[[mujoco.MjModel, mujoco.MjData], Any] | None) -> Step:
        """Return what makes a physics step with these motors.

        Args:
            within: called within the step, when MuJoCo's constraints are known.
        """
        first_half, second_half = mujoco.mj_step1, mujoco.mj_step2

        def step(model: mujoco.MjModel, data: mujoco.MjData) -> None:
            if self._with_friction:
                self._resist(model, data)
            first_half(model, data)
            if within is not None:
                within(model, data)
            rows = self._present_rows(data)
            data.efc_aref[rows] = self._references(model, data)
            self._grip.hold(model, data)
            second_half(model, data)
            self._report(data, rows)

        return step

    def _present_rows(self, data: mujoco.MjData) -> NDArray[np.intp]:
        """Return the rows of the motors among the constraints of this physics step."""
        first = data.ne
        if data.nf == self._rows_in_all:
            return self._rows if not first else self._rows + first
        # Constraints of sleeping bodies are left out. A body with a motor never sleeps.
        last = first + data.nf
        kinds, ids = data.efc_type[first:last].tolist(), data.efc_id[first:last].tolist()
        present = {key: first + row for row, key in enumerate(zip(kinds, ids, strict=True))}
        return np.array(
            [present[_ROW_TYPES[b.element], b.dof if b.element == "joint" else b.id] for b in self._bindings],
            dtype=np.intp,
        )

    def _references(self, model: mujoco.MjModel, data: mujoco.MjData) -> NDArray[np.float64]:
        """Return the acceleration by which each motor reaches its command in this physics step, rad/s^2 or m/s^2."""
        wanted, velocity = self._wanted, self._velocity
        data.qvel.take(self._dofs, out=self._of_joints, mode="clip")
        if self._tendons.size:
            data.ten_velocity.take(self._tendons, out=self._of_tendons, mode="clip")
        data.ctrl.take(self._ctrl, out=wanted, mode="clip")
        if self._has_gear:
            np.divide(wanted, self._gear, wanted)
        np.subtract(wanted, velocity, wanted)
        # A command out of reach asks for the maximum force; greater numbers would cost the solver its digits.
        np.clip(wanted, -MOST_VELOCITY, MOST_VELOCITY, out=wanted)
        np.divide(wanted, model.opt.timestep, wanted)
        return wanted

    def _report(self, data: mujoco.MjData, rows: NDArray[np.intp]) -> None:
        """Write the forces where MuJoCo keeps those of actuators; it computes its own anew in each step."""
        force = data.efc_force[rows]
        if self._has_gear:
            np.divide(force, self._gear, force)
        data.actuator_force[self._out] = force

    def _resist(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Let the friction of the joints themselves act against the commanded motion.

        Their constraint is the motor's now, so the friction becomes a force of the actuator.
        """
        for binding in self._with_friction:
            direction = np.sign(data.ctrl[binding.ctrl] * binding.gear)
            model.actuator_biasprm[binding.actuator, 0] = -binding.friction * direction / binding.gear
