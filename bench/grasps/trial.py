"""A grasp: the gripper takes a thing from a column, lifts it, turns it upside down, carries it to and fro, holds it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .closing import Fingers
from .grippers import Gripper
from .program import Array, Program
from .rig import LOW, NARROW, PART, Carriage, add_column, hang
from .things import Thing, corners

STEP = 0.05
"""Simulation step in s."""

HEIGHT = 0.6
"""Of the thing's lower side at first, m."""

ABOVE, RAISE = 0.2, 0.4
"""How far above its place the gripper opens, and how far it lifts the thing, m."""

SWING, FASTEST = 0.2, 0.5
"""Amplitude in m of the movement to and fro, and its greatest speed in m/s."""

LOST = 0.03
"""Metres across the closing direction from which on a thing counts as lost."""

Move = Callable[[float], Mapping[str, float]]
"""The places of the carriage's axes after a part of a phase."""


@dataclass(frozen=True)
class Held:
    """What became of a grasp; all movement is that in the frame of the hand."""

    slip: float
    """How far the thing moved across the closing direction while it was lifted, turned and carried, mm."""
    turn: float
    """By how much it turned meanwhile, degrees."""
    creep: float
    """How far it moved across the closing direction while it was held, mm."""
    aside: float
    """How far it moved in the closing direction, together with the fingers, mm."""
    lost: bool


class Grasp:
    """A simulation with a gripper on a carriage, and a thing below it."""

    def __init__(self, program: Program, gripper: Gripper, thing: Thing, models: Path, things: Path) -> None:
        """Build it.

        Args:
            models: PyRep's folder `robot_ttms/end_effectors`.
            things: RLBench's folder `task_ttms`.
        """
        self.program = program
        self.hand = program.call("loadModel", str(models / gripper.file))
        self.held = thing.bring(program, things)
        low, high = corners(program, self.held)
        foot = ((low + high) / 2 * (1.0, 1.0, 0.0)) + (0.0, 0.0, low[2])
        program.place(self.held, program.pose(self.held)[:, 3] - foot + (0.0, 0.0, HEIGHT))
        above = thing.grip[1] * (high[2] - low[2])
        self.carriage: Carriage = hang(
            program, gripper, self.hand, np.array((thing.grip[0], 0.0, HEIGHT + above))
        )
        add_column(program, HEIGHT, NARROW if above < LOW else PART * min((high - low)[:2]))
        self._places = {"across": 0.0, "lift": ABOVE, "tilt": 0.0}

    def go(self, seconds: float, move: Move, command: Callable[[], None]) -> list[Array]:
        """Move the carriage; return the poses of the thing in the hand after each simulation step."""
        count, poses = round(seconds / STEP), list[Array]()
        for number in range(1, count + 1):
            self._places.update(move(number / count))
            self.carriage.drive(self._places, STEP)
            command()
            self.program.step()
            poses.append(self.program.pose(self.held, self.hand))
        return poses


def trial(
    gripper: Gripper,
    thing: Thing,
    models: Path,
    things: Path,
    *,
    keeps_closing: bool = True,
    seconds: float = 30.0,
    each_second: Callable[[Program], None] | None = None,
) -> Held:
    """Let a gripper carry a thing.

    Args:
        models: PyRep's folder `robot_ttms/end_effectors`.
        things: RLBench's folder `task_ttms`.
        keeps_closing: see `Fingers`.
        seconds: how long the thing is held at last.
        each_second: called in each second while it is held.
    """
    with Program() as program:
        grasp = Grasp(program, gripper, thing, models, things)
        fingers = Fingers(program, gripper, keeps_closing=keeps_closing)
        go, command = grasp.go, fingers.command
        program.call("startSimulation")
        fingers.open()
        go(2.5, lambda _: {}, command)
        go(1.5, lambda part: {"lift": ABOVE * (1 - _smooth(part))}, command)
        fingers.close()
        first = go(4.0, lambda _: {}, command)[-1]
        carried = go(1.5, lambda part: {"lift": RAISE * _smooth(part)}, command)
        carried += go(2.0, lambda part: {"tilt": math.pi * _smooth(part)}, command)
        angle = 4 * math.pi
        carried += go(
            angle * SWING / FASTEST, lambda part: {"across": SWING * (1 - math.cos(angle * part))}, command
        )
        rest = go(1.0, lambda _: {}, command)
        for _ in range(round(seconds)):
            if each_second is not None:
                each_second(program)
            rest += go(1.0, lambda _: {}, command)
    return summed_up(first, carried, rest, gripper)


def summed_up(first: Array, carried: list[Array], rest: list[Array], gripper: Gripper) -> Held:
    """Return what became of a grasp, from the poses of the thing in the hand in each simulation step.

    Args:
        first: when the gripper has closed.
        carried: while the thing is carried.
        rest: later; in its first second the hand comes to rest.
    """
    at_rest = rest[round(1 / STEP) - 1 :]
    moved = [_split(pose, first, gripper) for pose in (*carried, *rest)]
    return Held(
        slip=1e3 * max(across for across, _ in moved[: len(carried)]),
        turn=max(_angle(pose, first) for pose in carried),
        creep=1e3 * max(_split(pose, at_rest[0], gripper)[0] for pose in at_rest),
        aside=1e3 * max(along for _, along in moved),
        lost=max(across for across, _ in moved) > LOST,
    )


def _split(pose: Array, first: Array, gripper: Gripper) -> tuple[float, float]:
    """Return how far a thing moved across the closing direction and in it, m."""
    way = pose[:, 3] - first[:, 3]
    along = float(way @ gripper.across)
    return float(np.linalg.norm(way - along * np.array(gripper.across))), abs(along)


def _smooth(part: float) -> float:
    """Return the part of a way after a part of its time, without jerks at both ends."""
    return part**3 * (10.0 - 15.0 * part + 6.0 * part * part)


def _angle(one: Array, other: Array) -> float:
    """Return by how much two poses are turned against each other, degrees."""
    chord = float(np.linalg.norm(one[:, :3] - other[:, :3])) / math.sqrt(8)
    return math.degrees(2 * math.asin(min(1.0, chord)))
