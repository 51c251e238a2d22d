"""Compute what is compared of a simulation's state: checksums after every simulation step, digests at intervals."""

from __future__ import annotations

import hashlib
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_server.scene.editing.model_state import get_state

if TYPE_CHECKING:
    from simx_server.parts.communication.signals import Signals
    from simx_server.world.world import World

DIGEST = 8
"""Bytes of a digest (BLAKE2b): by chance, two states have the same one once in 10**19 times."""

_STEP = struct.Struct("<II")

_MODEL = (
    "qpos0", "body_pos", "body_quat", "body_mass", "body_inertia", "jnt_range", "jnt_stiffness", "dof_damping",
    "geom_pos", "geom_quat", "geom_size", "geom_friction", "geom_contype", "geom_conaffinity", "geom_rgba",
    "site_pos", "site_quat", "cam_pos", "cam_quat", "actuator_gainprm", "actuator_biasprm", "actuator_forcerange",
    "eq_data",
)  # fmt: skip
"""The arrays of a model that commands write: poses of static objects, masses, limits, motors' gains."""

_LONG = 4096
"""Bytes of a string signal above which only its length counts."""


def of_step(data: mujoco.MjData) -> bytes:
    """Return the CRC-32 of the positions and of the velocities."""
    return _STEP.pack(zlib.crc32(data.qpos), zlib.crc32(data.qvel))


def differences_of_step(one: bytes, other: bytes) -> list[str]:
    """Return the names of the quantities in which two simulation steps differ."""
    names = ("positions (qpos)", "velocities (qvel)")
    return [name for place, name in enumerate(names) if one[4 * place :][:4] != other[4 * place :][:4]]


def digests(world: World) -> list[bytes]:
    """Return one digest of each quantity, in order of `QUANTITIES`."""
    return [hashlib.blake2b(b"".join(parts), digest_size=DIGEST).digest() for parts in _quantities(world)]


def differences(one: Sequence[object], other: Sequence[object]) -> list[str]:
    """Return the names of the quantities in which two lists of digests differ."""
    if len(one) != len(other):
        return ["what is compared"]
    return [name for name, mine, its in zip(QUANTITIES, one, other, strict=True) if mine != its]


QUANTITIES = (
    "time",
    "positions (qpos)",
    "velocities (qvel)",
    "activations (act)",
    "controls (ctrl)",
    "applied forces (qfrc_applied, xfrc_applied)",
    "the rest of the integration state",
    "the model's arrays",
    "signals",
)


def _quantities(world: World) -> Iterator[list[Any]]:
    sim = world.simulation
    model, data = sim.model, sim.data
    yield [struct.pack("<qdd", sim.step_count, sim.time_step, data.time), sim.state.value.encode()]
    yield [data.qpos.tobytes()]
    yield [data.qvel.tobytes()]
    yield [data.act.tobytes()]
    yield [data.ctrl.tobytes()]
    yield [data.qfrc_applied.tobytes(), data.xfrc_applied.tobytes()]
    yield [get_state(model, data).tobytes()]
    yield [np.ascontiguousarray(getattr(model, name)).tobytes() for name in _MODEL]
    yield list(_signals(world.signals))


def _signals(signals: Signals) -> Iterator[bytes]:
    for name, number in sorted([*signals.integers.items(), *signals.floats.items()]):
        yield f"{name!r}={number!r};".encode("utf-8", "surrogateescape")
    for name, text in sorted(signals.strings.items()):
        yield f"{name!r}:{len(text)};".encode("utf-8", "surrogateescape")
        yield text if len(text) <= _LONG else b""
