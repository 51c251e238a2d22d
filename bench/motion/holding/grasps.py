"""A gripper on a carriage: it takes an object from a pedestal, lifts it, turns it upside down, moves it, and holds it.

`trial` returns how far the object has moved in the hand, in numbers.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from bench.motion.holding.held_objects import add_object, add_pedestal
from bench.motion.models import build_model, read_model
from simx_client.protocol.constants import sim_buttonproperty_isdown
from simx_server.scene.formats.annotations import PREFIX

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
    opening: float = 2.0
    closing: float = 3.0
    """Seconds that it needs."""


@dataclass(frozen=True)
class Held:
    """What became of a grasp."""

    shift: float
    """How far the object moved in the hand while it was lifted, turned and carried, mm."""
    creep: float
    """How far it moved in 30 s of rest, mm."""
    lost: bool
    hold: float
    """Friction that the closed fingers can give before the object is lifted, as a part of its weight."""
    force: dict[str, tuple[float, float]]
    """Mean and standard deviation of the motors' forces while it was held, N or N m."""


def trial(file: Path, hand: Hand, kind: str, mass: float, seconds: float = 30.0) -> Held:
    """Let a gripper carry an object.

    Args:
        file: the gripper's model, of any format.
        kind: of object, see `held_objects`.
        mass: of the object, kg.
        seconds: how long the object is held at last.

    Raises:
        RuntimeError: the physics diverged.
    """
    spec = read_model(file, scripted=bool(hand.signal or hand.button))
    body = spec.body(hand.body)
    for joint in list(body.joints):
        spec.delete(joint)
    _turn_down(body, hand)
    _add_carriage(spec, body)
    add_object(spec, kind, mass, (0.0, 0.0, _HEIGHT))
    add_pedestal(spec, (0.0, 0.0, _HEIGHT))
    return _carry(build_model(spec, file), hand, seconds)


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


def _carry(world: Any, hand: Hand, seconds: float) -> Held:
    simulation = world.simulation
    joints, find = simulation.joints, simulation.scene.resolve
    axes = [find(name) for name in ("across", "lift", "tilt")]
    motors = {name: find(name) for name in hand.closes}
    poses: list[NDArray[np.float64]] = []
    phases: list[str] = []
    friction = 0.0
    forces: list[list[float]] = []
    simulation.start()
    data = simulation.data
    end = hand.opening + 1.0 + hand.closing + 7.5 + seconds
    for number in range(round(end / _STEP)):
        *places, phase = _course((number + 1) * _STEP, hand)
        for axis, place in zip(axes, places, strict=True):
            joints.set_target_velocity(axis, (place - joints.position(axis)) / _STEP)
        _command(world, hand, motors, opens=phase == "open")
        before = data.time
        world.step()
        if data.time <= before:  # the server stops a simulation that diverges
            raise RuntimeError(f"the physics diverged at {before:.2f} s")
        poses.append(_pose_in_hand(data, hand.body))
        phases.append(phase)
        if phase == "close":
            friction = _friction(simulation.model, data)
        if phase == "hold":
            forces.append([joints.force(handle) for handle in motors.values()])
    simulation.stop()
    model = simulation.model
    weight = float(model.body("held").mass[0] * np.linalg.norm(model.opt.gravity))
    return _sum_up(poses, phases, friction / weight, np.array(forces), list(motors))


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


def _friction(model: Any, data: Any) -> float:
    """Return the most friction in N that the fingers can give the object: the sum over their contacts of mu times N."""
    held, pedestal = model.body("held").id, model.geom("pedestal").id
    force, friction = np.zeros(6), 0.0
    for index, contact in enumerate(data.contact[: data.ncon]):
        if held in model.geom_bodyid[contact.geom] and pedestal not in contact.geom:
            mujoco.mj_contactForce(model, data, index, force)
            friction += float(contact.friction[0] * force[0])
    return friction


def _pose_in_hand(data: Any, body: str) -> NDArray[np.float64]:
    """Return the object's place in the hand's frame."""
    hand, held = data.body(body), data.body("held")
    return hand.xmat.reshape(3, 3).T @ (held.xpos - hand.xpos)


def _sum_up(
    poses: list[NDArray[np.float64]],
    phases: list[str],
    hold: float,
    forces: NDArray[np.float64],
    motors: list[str],
) -> Held:
    first, held = phases.index("carry"), phases.index("hold")
    way = np.linalg.norm([pose - poses[first] for pose in poses[first:]], axis=1)
    rest = np.linalg.norm([pose - poses[held] for pose in poses[held:]], axis=1)
    spread = {
        name: (float(mean), float(deviation))
        for name, mean, deviation in zip(motors, forces.mean(axis=0), forces.std(axis=0), strict=True)
    }
    return Held(
        shift=1e3 * float(way[: held - first].max()),
        creep=1e3 * float(rest.max()),
        lost=bool(way.max() > _LOST),
        hold=hold,
        force=spread,
    )
