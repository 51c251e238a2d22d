"""Static shapes whose surfaces move: belts with a velocity, and shapes that programs move.

In V-REP such a shape drags what touches it. To MuJoCo a body without degrees of freedom is always at rest, so the
velocities of its contacts are corrected: within each physics step the constraint's reference acceleration, which is
proportional to the velocity of the two surfaces against each other, gets the missing part. Friction, slip and rolling
then follow exactly as if the body had this velocity.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass

from .part import Part
from .simulation import Simulation

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins

Array = NDArray[np.float64]

FASTEST, FASTEST_TURN = 5.0, 20.0
"""m/s and rad/s; what is put farther away within a simulation step was placed, and has not moved there."""

_STILL = 1e-9


@dataclass
class _Motion:
    """Bodies that programs moved since the last simulation step, in the frames of their parents."""

    bodies: NDArray[np.intp]
    start: Array
    """(n, 3) positions."""
    end: Array
    start_turns: Array
    """(n, 4) quaternions."""
    end_turns: Array


class Surfaces(Part):
    """The moving surfaces of one simulation."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._own: dict[int, tuple[float, ...]] = {}
        """Velocities that belts were given: handle to linear m/s and angular rad/s, world axes."""
        self._bodies: NDArray[np.intp] = np.zeros(0, np.intp)
        """Static bodies with geoms, and those that carry such bodies, of the model."""
        self._model: mujoco.MjModel | None = None
        self._world: tuple[Array, Array] = (np.zeros((0, 3)), np.zeros((0, 4)))
        self._local: tuple[Array, Array] = (np.zeros((0, 3)), np.zeros((0, 4)))
        """Their poses after the last simulation step, in the world and in their parents."""
        self._put: set[int] = set()
        """Handles of objects that were reset since the last simulation step: they are put where they go."""
        self._velocities: dict[int, list[float]] = {}
        """Linear and angular velocity about its origin of each body that moves, by MuJoCo's id."""
        self._motion: _Motion | None = None
        self._first_time = 0.0

    def run_started(self) -> None:
        self._own = {}
        self._rebase()

    def run_stopped(self) -> None:
        self._own = {}
        self._rest()

    def scene_closing(self) -> None:
        self._own = {}
        self._rest()

    def model_changed(self, twins: Twins | None) -> None:
        self._rebase()

    def remember(self) -> object:
        return dict(self._own)

    def recall(self, memory: Any) -> None:
        self._own = dict(memory)
        self._rebase()

    @property
    def are_moving(self) -> bool:
        """Return whether any surface moves in this simulation step."""
        return bool(self._velocities)

    def drive(self, handle: int, velocity: Sequence[float]) -> None:
        """Give the surface of a static shape a velocity until the run ends: linear m/s, angular rad/s, world axes."""
        if any(velocity):
            self._own[handle] = tuple(velocity)
        else:
            self._own.pop(handle, None)

    def put(self, handles: Iterable[int]) -> None:
        """Have objects be at their places of the next simulation step from its start, without a way there.

        In V-REP a reset removes a shape from the physics engine, which gets it again at its new place.
        """
        self._put.update(handles)

    @property
    def has_work(self) -> bool:
        """Return whether surfaces could move, and drag something."""
        return bool(self._sim.model.nv and len(self._bodies))

    @property
    def are_to_move(self) -> bool:
        """Return whether a surface moves, or a body was moved that could drag something."""
        if self._own or self._velocities or self._put:
            return True
        if not (self._sim.is_rearranged and len(self._bodies)):
            return False
        self._sim.refresh()
        places, turns = self._world
        data = self._sim.data
        return bool(
            (_differ(data.xpos[self._bodies], places) | _differ(data.xquat[self._bodies], turns)).any()
        )

    def prepare(self) -> None:
        """Find what moves in the physics of this simulation step; called right before it."""
        sim = self._sim
        if not (sim.is_rearranged or self._own or self._velocities):
            return
        velocities = self._of_moved_bodies() if sim.is_rearranged else {}
        if not sim.dynamics_enabled:
            self._motion = None
            return
        for handle, own in self._own.items():
            item = sim.scene.objects.get(handle)
            if item is not None and item.element == "body":
                before = velocities.get(item.id, [0.0] * 6)
                velocities[item.id] = [a + b for a, b in zip(before, own, strict=True)]
        if not velocities:
            self._rest()
            return
        sim.joints.controllers.call_within_steps(self._within)
        self._velocities = velocities
        self._first_time = sim.data.time
        if self._motion is not None:
            self._place(0.0)
        sim.sleepers.note_moving_surfaces(True)

    def finish(self) -> None:
        """Put moved bodies at their ends; called right after the physics."""
        if self._motion is not None:
            self._place(1.0)
            self._motion = None
            self._sim.changed()
            self._sim.refresh()

    def _of_moved_bodies(self) -> dict[int, list[float]]:
        """Return the velocities of bodies that were moved since the last simulation step."""
        sim = self._sim
        sim.refresh()
        places, turns = sim.data.xpos[self._bodies], sim.data.xquat[self._bodies]
        before, before_turns = self._world
        local = sim.model.body_pos[self._bodies], sim.model.body_quat[self._bodies]
        local_before = self._local
        self._world, self._local = (places, turns), local
        is_moved = _differ(places, before) | _differ(turns, before_turns)
        is_moved &= ~np.isin(self._bodies, self._put_bodies())
        if not self._collide(self._bodies[is_moved]):
            return {}
        velocities: dict[int, list[float]] = {}
        for place in np.flatnonzero(is_moved):
            with np.errstate(over="ignore"):  # a script may put a body anywhere
                linear = (places[place] - before[place]) / sim.time_step
            angular = _turn(before_turns[place], turns[place]) / sim.time_step
            if math.hypot(*linear.tolist()) <= FASTEST and math.hypot(*angular.tolist()) <= FASTEST_TURN:
                velocities[int(self._bodies[place])] = [*linear.tolist(), *angular.tolist()]
            else:
                is_moved[place] = False
        slid = _differ(local[0], local_before[0]) | _differ(local[1], local_before[1])
        slid &= is_moved
        self._motion = _Motion(
            self._bodies[slid], local_before[0][slid], local[0][slid], local_before[1][slid], local[1][slid]
        )
        return velocities

    def _put_bodies(self) -> list[int]:
        """Return the bodies of the objects that were reset since the last simulation step, and forget them."""
        found = (self._sim.scene.objects.get(handle) for handle in self._put)
        bodies = [item.id for item in found if item is not None and item.element == "body"]
        self._put.clear()
        return bodies

    def _collide(self, bodies: NDArray[np.intp]) -> bool:
        """Return whether anything may touch one of these bodies."""
        model = self._sim.model
        if not len(bodies):
            return False
        collides = (model.geom_contype | model.geom_conaffinity) != 0
        return bool(np.isin(model.geom_bodyid[collides], bodies).any())

    def _place(self, share: float) -> None:
        """Put moved bodies at a share of their ways: V-REP moves them in each of its dynamics steps."""
        motion, model = self._motion, self._sim.model
        assert motion is not None
        if share >= 1.0:
            model.body_pos[motion.bodies], model.body_quat[motion.bodies] = motion.end, motion.end_turns
            return
        model.body_pos[motion.bodies] = motion.start + share * (motion.end - motion.start)
        # The ways are short: the sum of two quaternions on the same side is the rotation between them.
        sides = np.sign(np.sum(motion.start_turns * motion.end_turns, axis=1, keepdims=True))
        turns = motion.start_turns + share * (sides * motion.end_turns - motion.start_turns)
        model.body_quat[motion.bodies] = turns / np.linalg.norm(turns, axis=1, keepdims=True)

    def _within(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Correct the contacts, and place moved bodies for the next physics step; see `stepper.Within`."""
        if data.ncon:
            _drive(model, data, self._velocities)
        if self._motion is not None:
            done = (data.time - self._first_time + model.opt.timestep) / self._sim.time_step
            self._place(min(1.0, max(0.0, done)))

    def _rebase(self) -> None:
        """Take the present poses as those after the last simulation step."""
        sim = self._sim
        self._rest()
        self._put.clear()
        sim.refresh()
        model, data = sim.model, sim.data
        if self._model is not model:
            self._model, self._bodies = model, _static_bodies(model)
        self._world = data.xpos[self._bodies], data.xquat[self._bodies]
        self._local = model.body_pos[self._bodies], model.body_quat[self._bodies]

    def _rest(self) -> None:
        self._motion = None
        if self.are_moving:
            self._velocities = {}
            self._sim.sleepers.note_moving_surfaces(False)
            self._sim.joints.controllers.call_within_steps(None)


def _differ(first: Array, second: Array) -> NDArray[np.bool_]:
    """Return for each row whether it differs by more than rounding."""
    return np.abs(first - second).max(axis=1, initial=0.0) > _STILL


def _turn(old: Array, new: Array) -> Array:
    """Return the rotation vector from one quaternion to another, world axes."""
    difference, vector = np.empty(4), np.empty(3)
    back = np.array([old[0], -old[1], -old[2], -old[3]])
    mujoco.mju_mulQuat(difference, new, back)
    if difference[0] < 0:
        difference = -difference
    mujoco.mju_quat2Vel(vector, difference, 1.0)
    return vector


def _static_bodies(model: mujoco.MjModel) -> NDArray[np.intp]:
    """Return the ids of static bodies that have geoms or carry bodies with geoms."""
    has_geoms = np.zeros(model.nbody, bool)
    bodies = model.geom_bodyid
    while len(bodies):
        has_geoms[bodies] = True
        above = np.unique(model.body_parentid[bodies])
        bodies = above[~has_geoms[above]]
    has_geoms[0] = False
    return np.nonzero(has_geoms & (model.body_weldid == 0))[0]


def _drive(model: mujoco.MjModel, data: mujoco.MjData, velocities: Mapping[int, Sequence[float]]) -> None:
    """Add the velocities of surfaces to the reference accelerations of their contacts.

    Args:
        velocities: linear and angular velocity about the origin of each body that moves, world axes.
    """
    contact = data.contact
    is_elliptic = model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC.value
    damping, target = data.efc_KBIP, data.efc_aref
    of_geom = model.geom_bodyid
    # Plain numbers: there are few such contacts, and each operation on an array costs as much as one of them.
    for index, (geoms, first) in enumerate(
        zip(contact.geom.tolist(), contact.efc_address.tolist(), strict=True)
    ):
        # A flex has no geom; its surface does not move.
        sides = [velocities.get(int(of_geom[geom])) if geom >= 0 else None for geom in geoms]
        if first < 0 or sides == [None, None]:
            continue
        place, frame = contact.pos[index].tolist(), contact.frame[index].tolist()
        linear, angular = [0.0] * 3, [0.0] * 3
        for geom, own, sign in zip(geoms, sides, (1.0, -1.0), strict=True):
            if own is None:
                continue
            x, y, z = (a - b for a, b in zip(place, data.xpos[of_geom[geom]].tolist(), strict=True))
            vx, vy, vz, wx, wy, wz = own
            linear[0] += sign * (vx + wy * z - wz * y)
            linear[1] += sign * (vy + wz * x - wx * z)
            linear[2] += sign * (vz + wx * y - wy * x)
            for axis, rate in enumerate((wx, wy, wz)):
                angular[axis] += sign * rate
        # Along the normal and the two tangents; then about them.
        parts = [
            sum(frame[3 * row + axis] * each[axis] for axis in range(3))
            for each in (linear, angular)
            for row in range(3)
        ]
        size = int(contact.dim[index])
        if is_elliptic or size == 1:
            for row in range(size):
                target[first + row] += damping[first + row, 1] * parts[row]
            continue
        for row, friction in enumerate(contact.friction[index].tolist()[: size - 1]):
            for at, sign in ((first + 2 * row, friction), (first + 2 * row + 1, -friction)):
                target[at] += damping[at, 1] * (parts[0] + sign * parts[1 + row])
