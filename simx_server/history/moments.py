"""The world after one simulation step: everything that the next step depends on, saved in few bytes and restored.

Consecutive steps share what is equal: the model and its arrays, settings, signals. A step of a robot with twenty joints
takes 15 kB and 60 us.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.joints.moments import Moment as JointsMoment
from simx_server.parts.communication.signals import Values
from simx_server.scene.editing.model_state import STATE, get_state
from simx_server.simulation.parts import Memories
from simx_server.simulation.saved_state import Snapshot
from simx_server.simulation.sleepers import Asleep

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation
    from simx_server.world.world import World

_DERIVED = ("qfrc_bias", "actuator_force", "sensordata", "ten_length", "qacc")
"""Arrays of MuJoCo's data that are read before the next physics step, and that the state does not determine: they are
of the start of the last physics step.
"""

_BASE = 5000
"""About how many bytes a moment takes beside the numbers in its arrays (measured with tracemalloc)."""


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """The model with its arrays and the tree of objects, which rarely change.

    State and joints of `snapshot` are not used.

    The contents of arrays are shared with the structure before.
    """

    snapshot: Snapshot
    version: int
    """`Simulation.model_version`."""

    gravity: bytes
    size: int


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """The world after a simulation step of a run; step 0 is its start."""

    step: int
    structure: Structure
    state: np.ndarray
    """Of `STATE`."""

    derived: list[np.ndarray]
    asleep: Asleep | None

    joints: JointsMoment
    signals: Values
    parts: Memories
    next_handle: int
    dynamics_enabled: bool
    is_rearranged: bool
    has_overlaps: bool
    size: int
    """About how many bytes it takes beside the moment before."""

    @property
    def model(self) -> mujoco.MjModel:
        return self.structure.snapshot.model


def take(world: World, before: Moment | None) -> Moment:
    """Save the world as it is now.

    Args:
        before: the moment before, of the same run, to share what is equal; None: there is none.
    """
    sim = world.simulation
    data = sim.data
    joints, is_changed = sim.joints.remember_moment(before.joints if before else None)
    structure = before.structure if before else None
    size = _BASE
    if structure is None or is_changed or not _is_current(structure, sim):
        structure = _structure(sim, structure)
        size += structure.size
    signals, bytes_of_signals = world.signals.remember(before.signals if before else None)
    state = get_state(sim.model, data)
    derived = [getattr(data, name).copy() for name in _DERIVED]
    asleep = sim.sleepers.remember()
    if asleep is not None:
        size += sum(each.nbytes for each in asleep[0].values())
    return Moment(
        sim.step_count,
        structure,
        state,
        derived,
        asleep,
        joints,
        signals,
        sim.parts.remember(before.parts if before else None),
        sim.scene.next_handle,
        sim.dynamics_enabled,
        sim.is_rearranged,
        world.physics.has_overlaps,
        size + state.nbytes + sum(each.nbytes for each in derived) + joints.size + bytes_of_signals,
    )


def _is_current(structure: Structure, sim: Simulation) -> bool:
    saved, scene = structure.snapshot, sim.scene
    return (
        saved.model is sim.model
        and saved.scene is scene
        and structure.version == sim.model_version
        and structure.gravity == sim.model.opt.gravity.tobytes()
        and saved.overrides == scene.parent_overrides
        and saved.model_properties == scene.model_properties
        and saved.annotations is scene.annotations
    )


def _structure(sim: Simulation, before: Structure | None) -> Structure:
    snapshot = sim.snapshot()
    size = 300 * len(snapshot.parents) + 130 * len(snapshot.arrays)
    if before is not None and before.snapshot.model is snapshot.model:
        earlier = before.snapshot.arrays
        snapshot.arrays = [
            known if known == saved else saved for saved, known in zip(snapshot.arrays, earlier, strict=True)
        ]
        size += sum(
            len(saved) for saved, known in zip(snapshot.arrays, earlier, strict=True) if saved is not known
        )
    else:
        size += mujoco.mj_sizeModel(sim.model) + sum(map(len, snapshot.arrays))
    return Structure(snapshot, sim.model_version, sim.model.opt.gravity.tobytes(), size)


def restore(world: World, moment: Moment, before: Moment | None) -> None:
    """Set a run that has just started to a moment, so that the next step is the one that followed it.

    Args:
        before: the moment before it, from which velocities of objects follow; None: they are 0.
    """
    sim = world.simulation
    snapshot = replace(moment.structure.snapshot, state=moment.state, joints=moment.joints.settings)

    sim.go_back(snapshot, moment.step)
    sim.scene.next_handle = moment.next_handle
    sim.dynamics_enabled = moment.dynamics_enabled
    sim.joints.recall_moment(moment.joints)
    # Contacts, and what follows from them, are those of the state; they are not saved.
    sim.foresight.forward(sim.model, sim.data)
    world.signals.recall(moment.signals)
    world.velocities.go_on(_poses(before, moment))
    sim.parts.recall(moment.parts)
    _restore_data(sim.model, sim.data, moment)
    sim.sleepers.recall(moment.asleep)
    world.physics.go_on(is_rearranged=moment.is_rearranged, has_overlaps=moment.has_overlaps)


def _restore_data(model: mujoco.MjModel, data: mujoco.MjData, moment: Moment) -> None:
    """Restore all numbers, which the steps before have changed in part."""
    mujoco.mj_setState(model, data, moment.state, STATE)
    for name, saved in zip(_DERIVED, moment.derived, strict=True):
        getattr(data, name)[:] = saved


def _poses(before: Moment | None, moment: Moment) -> mujoco.MjData | None:
    if before is None or before.model is not moment.model:
        return None
    data = mujoco.MjData(moment.model)
    mujoco.mj_setState(moment.model, data, before.state, STATE)
    mujoco.mj_kinematics(moment.model, data)
    mujoco.mj_comPos(moment.model, data)
    mujoco.mj_camlight(moment.model, data)
    return data
