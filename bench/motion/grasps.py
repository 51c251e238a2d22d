"""A gripper on a carriage: it takes an object from a pedestal, lifts it, turns it upside down, moves it, and holds it.

`trial` returns how far the object has moved in the hand, in numbers.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from bench.motion.held_objects import add_object, add_pedestal
from simx_client.protocol.constants import sim_buttonproperty_isdown
from simx_server.scene.formats.annotations import PREFIX
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.specs import read_spec
from simx_server.world.building import build_world

SHIPPED_SCENES = Path(__file__).parents[2] / "scenes"

_STEP = 0.05
"""Simulation step in seconds."""

_ABOVE, _RAISE = 0.15, 0.2
"""Metres above the object at first, and after lifting."""

_SWING = 0.2
"""Amplitude in metres of the movement to and fro, with a greatest speed of 0.5 m/s."""

_HEIGHT = 0.6
"""Of the object above the floor at first, metres."""

_LOST = 0.03
"""Metres in the hand's frame from which on the object counts as lost."""


@dataclass(frozen=True)
class Hand:
    """A gripper: where it takes an object, and what opens and closes it."""

    body: str
    grip: float
    """Height in metres in the file, where its fingers point upwards, of the middle of what it takes."""
    opens: Mapping[str, float]
    """Target velocities of its motors, m/s or rad/s."""
    closes: Mapping[str, float]
    signal: str = ""
    """Integer signal for its script, 1: open, if the script moves the motors."""
    button: tuple[str, int] | None = None
    """Name of its UI, and number of the button that closes it while it is down, if its script moves the motors so."""
    turned: float = 0.0
    """Angle in radians about the fingers' direction by which the object is turned."""
    opening: float = 2.0
    closing: float = 3.0
    """Seconds that it needs."""
    at: tuple[float, float] = (0.0, 0.0)
    """Place of the object's middle across the fingers' direction."""


@dataclass(frozen=True)
class Held:
    """What became of a grasp."""

    shift: float
    """How far the object moved in the hand while it was lifted, turned and carried, mm."""
    creep: float
    """How far it moved in 30 s of rest, mm."""
    turn: float
    """Angle between its first and its last pose in the hand, degrees."""
    lost: bool
    force: dict[str, tuple[float, float]]
    """Mean and standard deviation of the motors' forces while it was held, N or N m."""
    contacts: float
    """Points of contact of the object, mean."""
    cost: float
    """Microseconds that a physics step takes, while the object is held."""

    def __str__(self) -> str:
        forces = ", ".join(f"{mean:.2f} ({spread:.3f})" for mean, spread in self.force.values())
        result = "LOST" if self.lost else "ok" if self.creep < 1 and self.shift < 1 else "creeps"
        return (
            f"{result:6} shift {self.shift:7.3f} creep {self.creep:7.3f} mm turn {self.turn:6.2f} deg "
            f"contacts {self.contacts:4.1f} {self.cost:5.0f} us force {forces}"
        )


def trial(
    file: Path,
    hand: Hand,
    kind: str,
    mass: float,
    edit: Callable[[Any], None] | None = None,
    seconds: float = 30.0,
    watch: Callable[..., None] | None = None,
) -> Held:
    """Let a gripper carry an object.

    Args:
        file: the gripper's model, of any format.
        kind: of object, see `held_objects`.
        mass: of the object, kg.
        edit: changes the MjSpec.
        seconds: how long the object is held at last.
        watch: called with world, time and phase after each simulation step.

    Raises:
        RuntimeError: the physics diverged.
    """
    spec: Any = _read(file, hand)
    body = spec.body(hand.body)
    for joint in list(body.joints):
        spec.delete(joint)
    _turn_down(body, hand)
    _add_carriage(spec, body)
    x, y = hand.at
    add_object(spec, kind, mass, (x, -y, _HEIGHT), hand.turned)
    add_pedestal(spec, (x, -y, _HEIGHT))
    if file.suffix == ".xml":
        _set_shipped_physics(spec)
    if edit is not None:
        edit(spec)
    world = build_world(None, workspace=None)  # pyright: ignore[reportArgumentType]
    world.simulation.use(*build(spec, file))
    return _carry(world, hand, seconds, watch)


def _read(file: Path, hand: Hand) -> Any:
    spec: Any = read_spec(file.resolve()).spec
    if not (hand.signal or hand.button):
        for text in list(spec.texts):
            if text.name.startswith((f"{PREFIX}script:", f"{PREFIX}lua:")):
                spec.delete(text)
    return spec


def _set_shipped_physics(spec: Any) -> None:
    """Simulate a shipped model as in the shipped scenes."""
    settings: Any = mujoco.MjSpec.from_file(str(SHIPPED_SCENES / "ur5_rg2_kinect.xml"))
    for name in ("timestep", "integrator", "cone", "impratio", "noslip_iterations"):
        setattr(spec.option, name, getattr(settings.option, name))


def _turn_down(body: Any, hand: Hand) -> None:
    """Let the fingers, which point upwards in a file, point downwards to the object."""
    x, y, z = body.pos
    turned = np.zeros(4)
    mujoco.mju_mulQuat(turned, np.array((0.0, 1.0, 0.0, 0.0)), body.quat)
    body.pos, body.quat = (x, -y, _HEIGHT + _ABOVE + hand.grip - z), turned


def _add_carriage(spec: Any, body: Any) -> None:
    """Hang the gripper on an axis across, one that lifts and one that turns."""
    types = mujoco.mjtJoint
    for name, kind, axis, start in (
        ("across", types.mjJNT_SLIDE, (1.0, 0.0, 0.0), 0.0),
        ("lift", types.mjJNT_SLIDE, (0.0, 0.0, 1.0), _ABOVE),
        ("tilt", types.mjJNT_HINGE, (0.0, 1.0, 0.0), 0.0),
    ):
        inverse, own = np.zeros(4), np.zeros(3)
        mujoco.mju_negQuat(inverse, body.quat)
        mujoco.mju_rotVecQuat(own, np.array(axis), inverse)
        body.add_joint(name=name, type=kind, axis=own, ref=start, limited=mujoco.mjtLimited.mjLIMITED_FALSE)
        spec.add_text(
            name=f"{PREFIX}joint:{name}",
            data="mode=force motor=on control=velocity rigid=yes max_force=10000 cyclic=no",
        )


def _course(time: float, hand: Hand) -> tuple[float, float, float, str]:
    """Return the places of the carriage's axes (m, m, rad) at a time in seconds, and what happens then."""
    closed = hand.opening + 1.0 + hand.closing
    lift = _ABOVE * (1.0 - _smooth(time - hand.opening)) + _RAISE * _smooth(time - closed - 0.5)
    tilt = math.pi * _smooth((time - closed - 2.0) / 2.0)
    moved = min(max(time - closed - 4.5, 0.0), 2 * math.pi * _SWING / 0.5)
    across = _SWING * (1.0 - math.cos(moved * 0.5 / _SWING))
    phase = "open" if time < hand.opening + 1.0 else "close" if time < closed else "carry"
    return across, lift, tilt, "hold" if time > closed + 7.5 else phase


def _smooth(share: float) -> float:
    """Return the part of a way after a share of its time, without jerks at both ends."""
    share = min(max(share, 0.0), 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share * share)


def _carry(world: Any, hand: Hand, seconds: float, watch: Callable[..., None] | None) -> Held:
    simulation = world.simulation
    joints, find = simulation.joints, simulation.scene.resolve
    axes = [find(name) for name in ("across", "lift", "tilt")]
    motors = {name: find(name) for name in hand.closes}
    poses: list[NDArray[np.float64]] = []
    phases: list[str] = []
    forces: list[list[float]] = []
    contacts: list[int] = []
    cost, steps = 0.0, 0
    simulation.start()
    model, data = simulation.model, simulation.data
    end = hand.opening + 1.0 + hand.closing + 7.5 + seconds
    for number in range(round(end / _STEP)):
        *places, phase = _course((number + 1) * _STEP, hand)
        for axis, place in zip(axes, places, strict=True):
            joints.set_target_velocity(axis, (place - joints.position(axis)) / _STEP)
        _command(world, hand, motors, opens=phase == "open")
        began, before = time.perf_counter(), data.time
        world.step()
        took = time.perf_counter() - began
        if data.time <= before:  # the server stops a simulation that diverges
            raise RuntimeError(f"the physics diverged at {before:.2f} s")
        poses.append(_pose_in_hand(model, data, hand.body))
        phases.append(phase)
        if watch is not None:
            watch(world, number * _STEP, phase)
        if phase == "hold":
            cost, steps = cost + took, steps + simulation.substeps
            forces.append([joints.force(handle) for handle in motors.values()])
            held = model.body("held").id
            contacts.append(int(np.sum(model.geom_bodyid[data.contact.geom] == held)))
    simulation.stop()
    return _sum_up(poses, phases, np.array(forces), contacts, list(motors), cost / steps * 1e6)


def _command(world: Any, hand: Hand, motors: Mapping[str, int], *, opens: bool) -> None:
    if hand.signal:
        world.signals.set_integer(hand.signal, int(opens))
        return
    if hand.button is not None:
        uis, (name, button) = world.user_interface.custom_uis, hand.button
        handle = uis.find(name)
        if bool(uis.get(handle).element(button).has(sim_buttonproperty_isdown)) == opens:
            uis.click(handle, button)
        return
    for name, velocity in (hand.opens if opens else hand.closes).items():
        world.simulation.joints.set_target_velocity(motors[name], velocity)


def _pose_in_hand(model: Any, data: Any, body: str) -> NDArray[np.float64]:
    """Return the object's place and orientation (a matrix) in the hand's frame, 12 numbers."""
    hand, held = data.body(body), data.body("held")
    turn = hand.xmat.reshape(3, 3).T
    return np.concatenate([turn @ (held.xpos - hand.xpos), (turn @ held.xmat.reshape(3, 3)).ravel()])


def _sum_up(
    poses: list[NDArray[np.float64]],
    phases: list[str],
    forces: NDArray[np.float64],
    contacts: list[int],
    motors: list[str],
    cost: float,
) -> Held:
    first, held = phases.index("carry"), phases.index("hold")
    way = np.linalg.norm([pose[:3] - poses[first][:3] for pose in poses[first:]], axis=1)
    rest = np.linalg.norm([pose[:3] - poses[held][:3] for pose in poses[held:]], axis=1)
    cosine = (np.dot(poses[first][3:], poses[-1][3:]) - 1) / 2
    spread = {
        name: (float(mean), float(deviation))
        for name, mean, deviation in zip(motors, forces.mean(axis=0), forces.std(axis=0), strict=True)
    }
    return Held(
        shift=1e3 * float(way[: held - first].max()),
        creep=1e3 * float(rest.max()),
        turn=math.degrees(math.acos(min(max(cosine, -1.0), 1.0))),
        lost=bool(way.max() > _LOST),
        force=spread,
        contacts=float(np.mean(contacts)),
        cost=cost,
    )
