"""The path objects of the scene, as in V-REP 3: curves in space, with a position that moves along them.

Dummies may follow the path above them: they are always at its position plus an offset. Conveyor belts of V-REP 3 are
made of such dummies, which carry the pads.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.formats.texts.path_points import points_of
from simx_server.scene.geometry.curve import LENGTH_PER_ANGLE, ControlPoint, Curve, Method, Rules
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.placing import place_all
from simx_server.scene.poses.poses import Pose, compose, inverse, normalised
from simx_server.scene.saved import numbers_text
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.copies.kept import Kept
    from simx_server.scene.formats.annotations import Annotation, Value
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

ORIENTATIONS = ("points", "curve", "curve_x_up")
"""Values of the annotation's key `orientation`: whose orientation Bezier points have."""


@dataclass(frozen=True)
class Track:
    """A path object's curve and settings."""

    curve: Curve
    position: float = 0.0
    """Metres along the curve."""
    target_velocity: float = 0.0
    """Nominal velocity that the position is to reach, m/s."""
    velocity: float = 0.0
    """Nominal velocity of the position, m/s."""
    acceleration: float = 0.0
    """m/s^2; 0: the target is reached at once."""
    is_explicit: bool = False
    """The position moves only when a script handles the path."""


@dataclass(frozen=True)
class Follower:
    """How a dummy follows its parent path."""

    offset: float = 0.0
    """Metres ahead of the path's position."""


class Paths(Part):
    """All path objects, by handle. The stop undoes a run's changes."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._tracks: dict[int, Track] = {}
        self._followers: dict[int, Follower | None] = {}
        """Settings that a script or client changed; None: does not follow."""
        self._before_the_run: tuple[dict[int, Track], dict[int, Follower | None]] = ({}, {})
        self.version = 0
        """Number that changes with every change of a curve."""
        self.is_enabled = True
        """Boolean parameter 8: if false, positions do not move automatically. A new scene starts with true."""

    def scene_changed(self) -> None:
        self._tracks, self._followers = {}, {}
        self.is_enabled = bool(self._sim.scene.annotations.scene.get("paths", True))
        self.version += 1

    def run_started(self) -> None:
        self._before_the_run = dict(self._tracks), dict(self._followers)

    def run_stopped(self) -> None:
        self._tracks, self._followers = self._before_the_run
        self.version += 1

    def remember(self) -> object:
        return dict(self._tracks), dict(self._followers), self.is_enabled

    def recall(self, memory: Any) -> None:
        tracks, followers, self.is_enabled = memory
        self._tracks, self._followers = dict(tracks), dict(followers)
        self.version += 1

    def objects_copied(self, copies: Mapping[int, int], kept: Kept) -> None:
        self._tracks |= {copies[handle]: each for handle, each in self._tracks.items() if handle in copies}
        self._followers |= {
            copies[handle]: each for handle, each in self._followers.items() if handle in copies
        }

    def saving(self, saved: Saved) -> None:
        for handle, track in self._tracks.items():
            if handle in saved.names:
                saved.put(handle, "path", **_note_of(track))
        for handle, follower in self._followers.items():
            if handle in saved.names:
                saved.put(handle, "follow", offset=None if follower is None else follower.offset)
        saved.settings["paths"] = self.is_enabled

    def handles(self) -> list[int]:
        """Return the handles of all paths."""
        return self._sim.scene.of_kind(ObjectKind.PATH)

    def get(self, handle: int) -> Track:
        """Return a path's curve and settings. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.PATH)
        if handle not in self._tracks:
            self._tracks[handle] = _track_of(item.annotations.get("path", {}))
        return self._tracks[handle]

    def set_points(
        self, handle: int, points: Sequence[ControlPoint], *, is_closed: bool | None = None
    ) -> None:
        """Replace the control points; None keeps whether the path is closed. Raises UnknownHandle, WrongKind."""
        track = self.get(handle)
        rules = track.curve.rules if is_closed is None else replace(track.curve.rules, is_closed=is_closed)
        curve = Curve(points, rules)
        self._tracks[handle] = replace(track, curve=curve, position=curve.along(track.position))
        self.version += 1
        self._carry(handle)

    def define(self, handle: int, track: Track) -> None:
        """Set a new path's curve and settings. Raises UnknownHandle, WrongKind."""
        self._sim.scene.get_kind(handle, ObjectKind.PATH)
        self._tracks[handle] = track
        self.version += 1

    def set_position(self, handle: int, position: float) -> None:
        """Set the position in metres: a closed path goes round, an open one ends. Raises UnknownHandle, WrongKind."""
        if not math.isfinite(position):
            raise CommandError(f"a position on a path is a finite number of metres, not {position}")
        track = self.get(handle)
        self._tracks[handle] = replace(track, position=track.curve.along(position))
        self._carry(handle)

    def set_target_velocity(self, handle: int, velocity: float) -> None:
        """Set the nominal velocity in m/s that the position is to reach. Raises UnknownHandle, WrongKind."""
        if not math.isfinite(velocity):
            raise CommandError(f"a velocity on a path is a finite number, not {velocity}")
        self._tracks[handle] = replace(self.get(handle), target_velocity=velocity)

    def pose_at(self, handle: int, position: float) -> Pose:
        """Return the world pose at a position in metres. Raises UnknownHandle, WrongKind, CommandError: no points."""
        return compose(get_pose(self._sim, handle), self.get(handle).curve.at(position).pose)

    def nearest(self, handle: int, place: Sequence[float]) -> float:
        """Return the position in metres that is nearest to a place in the world.

        Raises UnknownHandle, WrongKind, CommandError: no points.
        """
        x, y, z = place
        local = compose(inverse(get_pose(self._sim, handle)), ((x, y, z), (1.0, 0.0, 0.0, 0.0)))
        return self.get(handle).curve.nearest(local[0])

    @property
    def has_work(self) -> bool:
        """Return whether the scene has paths."""
        return bool(self.handles())

    def move(self) -> None:
        """Move the positions of all paths that are not explicit by a simulation step, as V-REP's main script does."""
        if self.is_enabled and (handles := self.handles()):
            seconds = self._sim.time_step
            for handle in handles:
                if not self.get(handle).is_explicit:
                    self.handle(handle, seconds)

    def handle(self, handle: int, seconds: float) -> None:
        """Move the position of one path. Raises UnknownHandle, WrongKind."""
        track = self.get(handle)
        velocity = track.target_velocity
        if track.acceleration > 0:
            most = track.acceleration * seconds
            velocity = track.velocity + min(max(velocity - track.velocity, -most), most)
        if velocity != track.velocity:
            self._tracks[handle] = track = replace(track, velocity=velocity)
        if velocity and track.curve.points:
            share = track.curve.at(track.position).velocity
            self.set_position(handle, track.position + velocity * share * seconds)

    def follower(self, handle: int) -> Follower | None:
        """Return how a dummy follows its parent path; None: it does not. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.DUMMY)
        if handle in self._followers:
            return self._followers[handle]
        note = item.annotations.get("follow")
        return None if note is None else Follower(float(note.get("offset", 0.0)))

    def set_follower(self, handle: int, follower: Follower | None) -> None:
        """Let a dummy follow its parent path, or not. Raises UnknownHandle, WrongKind."""
        item = self._sim.scene.get_kind(handle, ObjectKind.DUMMY)
        self._followers[handle] = follower
        if follower is not None and self._is_path(item.parent):
            self._carry(item.parent)

    def lines(self, most: int) -> list[tuple[int, list[tuple[float, ...]]]]:
        """Return for each path its handle and the lines along it in the world: x, y, z of both ends.

        Args:
            most: lines in all; the rest is left out.
        """
        found: list[tuple[int, list[tuple[float, ...]]]] = []
        for handle in self.handles():
            points = self.get(handle).curve.points[: most + 1]
            if len(points) > 1:
                frame = get_pose(self._sim, handle)
                places = [compose(frame, point.pose)[0] for point in points]
                found.append((handle, [(*start, *end) for start, end in pairwise(places)]))
                most -= len(points) - 1
        return found

    def _is_path(self, handle: int) -> bool:
        item = self._sim.scene.objects.get(handle)
        return item is not None and item.kind == ObjectKind.PATH

    def _carry(self, handle: int) -> None:
        """Place what follows a path."""
        track, objects = self._tracks[handle], self._sim.scene.objects
        if not track.curve.points:
            return
        frame = None
        wanted: list[tuple[SceneObject, Pose]] = []
        for child in self._sim.scene.children(handle):
            if objects[child].kind != ObjectKind.DUMMY or (follower := self.follower(child)) is None:
                continue
            if frame is None:
                frame = get_pose(self._sim, handle)
            local = track.curve.at(track.position + follower.offset).pose
            wanted.append((objects[child], compose(frame, local)))
        if wanted:
            place_all(self._sim, wanted)


def _track_of(note: Annotation) -> Track:
    """Return the path that an annotation describes."""
    orientation = str(note.get("orientation", ORIENTATIONS[0]))
    rules = Rules(
        is_closed=bool(note.get("closed", False)),
        method=Method[str(note.get("length", "distance_or_angle")).upper()],
        angle_to_length=float(note.get("angle_to_length", LENGTH_PER_ANGLE)),
        virtual_to_length=float(note.get("virtual_to_length", 1.0)),
        follows_curve=orientation != ORIENTATIONS[0],
        keeps_x_up=orientation == ORIENTATIONS[2],
        is_flat=bool(note.get("flat", False)),
    )
    numbers = points_of(str(note["points"])) if "points" in note else []
    curve = Curve([_control_point(each) for each in numbers], rules)
    velocity = float(note.get("velocity", 0.0))
    acceleration = float(note.get("acceleration", 0.0))
    return Track(
        curve,
        position=curve.along(float(note.get("position", 0.0))),
        target_velocity=velocity,
        acceleration=acceleration,
        is_explicit=bool(note.get("explicit", False)),
    )


def _note_of(track: Track) -> dict[str, Value | None]:
    """Return the annotation that describes a path."""
    rules, points = track.curve.rules, track.curve.control
    orientation = ORIENTATIONS[(1 + rules.keeps_x_up) if rules.follows_curve else 0]
    return {
        "points": ";".join(map(numbers_text, map(_numbers, points))) if points else None,
        "closed": rules.is_closed,
        "length": rules.method.name.lower(),
        "angle_to_length": rules.angle_to_length,
        "virtual_to_length": rules.virtual_to_length,
        "orientation": orientation,
        "flat": rules.is_flat,
        "position": track.position,
        "velocity": track.target_velocity,
        "acceleration": track.acceleration,
        "explicit": track.is_explicit,
    }


def _numbers(point: ControlPoint) -> list[float]:
    """Return the numbers of a point, as `_control_point` takes them."""
    place, turn = point.pose
    bezier = [point.before, point.after, point.count, point.virtual, point.velocity, point.flags]
    return [*place, *turn, *bezier, *point.channels]


def _control_point(numbers: Sequence[float]) -> ControlPoint:
    x, y, z, qw, qx, qy, qz, before, after, count, virtual, velocity, flags, *channels = numbers
    a, b, d, e = channels
    return ControlPoint(
        ((x, y, z), normalised((qw, qx, qy, qz))),
        before,
        after,
        int(count),
        max(0.0, virtual),
        velocity,
        int(flags),
        (a, b, d, e),
    )
