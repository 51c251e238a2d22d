"""Guess the drives and rings of robots without annotation, from their joints and proximity sensors.

Wheels are turning joints whose motors keep velocities and whose axes are level. Two or more on both sides make a
differential drive, four with rollers below 45 degrees a mecanum drive, and upright joints that move to positions above
driven wheels an Ackermann steering. The log has each guess in the form of an annotation.

A robot keeps its guess during a run, in which it may turn or tip over.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from simx_server.joints.servo import Rule
from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.objects import SceneObject
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import matrix
from simx_server.simulation.simulation import SimulationState

from .notes import note_of, sensors_below
from .wheels import (
    LEVEL,
    NoDrive,
    are_rollers_usual,
    axis_of,
    free_axle,
    has_rollers,
    is_level,
    place_of,
    radius_of,
    steering_of,
    turning_joints,
)  # fmt: skip

if TYPE_CHECKING:
    from simx_server.world.world import World

logger = logging.getLogger(__name__)

OFF = "off"
"""The name that stands for no guess."""

LEAST_RAYS = 5
"""Proximity sensors of a ring, which look in different level directions."""

_ALONG = 0.95
"""Least share of the way of the wheels along an axis of the base."""

_MIDDLE = 0.01
"""Distance from the middle, metres, within which a wheel is on no side."""

_SAME = 0.02
"""Share of the greatest radius by which the radii of wheels may differ."""

_AXES = "xyz"


class _Known(NamedTuple):
    """The guess for a robot."""

    parts: tuple[tuple[int, str], ...]
    """Handles and names of its joints and sensors."""

    drive: Annotation
    """Empty for none."""

    has_scan: bool


class Guesses:
    """The guesses for the present scene. Physics thread."""

    def __init__(self, world: World, wanted: str | None) -> None:
        """Make none yet.

        Args:
            wanted: the one robot whose drive is guessed; `off` for none; None: each robot without annotation.
        """
        self._world, self._wanted = world, wanted
        self._logged: set[str] = set()
        self._known: dict[int, _Known] = {}
        """By handle."""

    def make(self) -> dict[int, Annotation]:
        """Return annotations for robots that have none, by handle."""
        simulation = self._world.simulation
        scene = simulation.scene
        before, self._known = self._known, {}
        if self._wanted == OFF:
            return {}
        if simulation.state is SimulationState.STOPPED:
            before = {}
        if self._wanted is not None:
            handle = scene.by_name(self._wanted)
            if handle is None:
                self._say(logging.WARNING, f"--ros2-drive names '{self._wanted}', which is not in the scene")
                return {}
            return dict(self._of(scene.objects[handle], before))
        bases = [item for item in scene.objects.values() if scene.is_model_base(item.handle)]
        found: dict[int, Annotation] = {}
        for item in bases:
            within = (item.handle, *scene.descendants(item.handle))
            if not any("drive" in note_of(scene.objects[each]) for each in within):
                found.update(self._of(item, before))
        return found

    def _of(self, base: SceneObject, before: dict[int, _Known]) -> Iterator[tuple[int, Annotation]]:
        if note_of(base):
            if self._wanted is not None:
                self._say(logging.WARNING, f"'{base.name}' has an annotation, so its drive is not guessed")
            return
        known = self._known[base.handle] = self._guess(base, before.get(base.handle))
        note: Annotation = {**known.drive, **({"scan": "/scan"} if known.has_scan else {})}
        if note:
            text = " ".join(f"{key}={value}" for key, value in note.items())
            self._say(
                logging.INFO,
                f"guessed from joints and sensors, simx:ros2:{base.name} could be: {text}; annotate the scene to "
                "correct it",
            )
            yield base.handle, note

    def _guess(self, base: SceneObject, before: _Known | None) -> _Known:
        """Return a guess, with what was guessed before for the same joints and sensors."""
        parts = (*turning_joints(self._world, base), *sensors_below(self._world.simulation.scene, base))
        names = tuple((each.handle, each.name) for each in parts)
        drive, has_scan = (before.drive, before.has_scan) if before and before.parts == names else ({}, False)
        if not drive:
            try:
                drive = drive_of(self._world, base)
            except NoDrive as problem:
                if self._wanted is not None:
                    self._say(logging.WARNING, f"'{base.name}' has no drive: {problem}")
        return _Known(names, drive, has_scan or has_ring(self._world, base))

    def _say(self, level: int, text: str) -> None:
        if text not in self._logged:
            self._logged.add(text)
            logger.log(level, "ROS 2: %s", text)


def drive_of(world: World, base: SceneObject) -> Annotation:
    """Return the annotation of a robot's drive. Raises NoDrive."""
    simulation = world.simulation
    simulation.refresh()
    frame = np.array(matrix(object_pose(simulation, base)[1]))
    place = np.array(object_pose(simulation, base)[0])
    up = int(np.argmax(np.abs(frame[2])))
    vertical = frame[:, up] * np.sign(frame[2, up])
    wheels = _wheels(world, base)
    if len(wheels) < 2:
        raise NoDrive(
            "it has less than two wheels, turning joints with level axes whose motors keep velocities"
        )
    axes = [axis_of(world, each) for each in wheels]
    way = sum((np.cross(axis, vertical) for axis in axes), np.zeros(3))
    if np.linalg.norm(way) < 0.5:  # the axes of both sides are mirrored
        way = np.cross(axes[0], vertical)
        own = frame.T @ way  # in its own frame, so that a turned robot has the same front
        way = way if own[int(np.argmax(np.abs(own)))] > 0 else -way
    steering = [joint for each in wheels if (joint := steering_of(world, each)) is not None]
    if steering:
        rear = free_axle(world, base, wheels)
        front = np.mean([place_of(world, each) for each in steering], axis=0)
        way = way if (front - rear) @ way > 0 else -way
    way /= np.linalg.norm(way)
    shares = frame.T @ way
    forward = int(np.argmax(np.abs(shares)))
    if abs(shares[forward]) < _ALONG:
        raise NoDrive("its wheels roll along none of its axes")
    left = np.cross(vertical, way)
    sides: dict[str, list[SceneObject]] = {"left": [], "right": []}
    for each in wheels:
        beside = float((place_of(world, each) - place) @ left)
        if abs(beside) < _MIDDLE:
            raise NoDrive(f"its wheel {each.name} is in the middle")
        sides["left" if beside > 0 else "right"].append(each)
    if len(sides["left"]) != len(sides["right"]):
        raise NoDrive("its sides have different numbers of wheels")
    kind = "ackermann" if steering else "mecanum" if has_rollers(world, wheels) else "diff"
    if kind == "mecanum" and len(wheels) != 4:
        raise NoDrive("its wheels have rollers, and are not four")
    if kind == "mecanum" and not are_rollers_usual(world, wheels, np.real(way), left):
        raise NoDrive("its rollers stand the other way round than those of mecanum drives")
    radii = [radius_of(world, each) for each in wheels]
    if max(radii) - min(radii) > _SAME * max(radii):
        raise NoDrive(f"its wheels have radii from {min(radii):g} to {max(radii):g} m")
    note: Annotation = {
        "drive": kind,
        **{side: ",".join(each.name for each in joints) for side, joints in sides.items()},
        "radius": radii[0],
        "forward": f"{'-' if shares[forward] < 0 else ''}{_AXES[forward]}",
        "up": f"{'-' if frame[2, up] < 0 else ''}{_AXES[up]}",
    }
    if steering:
        note["steer"] = ",".join(each.name for each in steering)
    return note


def has_ring(world: World, base: SceneObject) -> bool:
    """Return whether a robot has a ring of proximity sensors that look in different level directions."""
    simulation = world.simulation
    simulation.refresh()
    looks: list[float] = []
    for each in sensors_below(simulation.scene, base):
        x, y, z = np.array(matrix(object_pose(simulation, each)[1]))[:, 2]
        if each.element != "site" or abs(z) > LEVEL:
            continue
        looks.append(round(float(np.degrees(np.arctan2(y, x)))))
    return len(set(looks)) >= LEAST_RAYS


def _wheels(world: World, base: SceneObject) -> list[SceneObject]:
    return [
        each
        for each in turning_joints(world, base)
        if world.simulation.joints.rule(each.handle) in (Rule.VELOCITY, Rule.HOLD) and is_level(world, each)
    ]
