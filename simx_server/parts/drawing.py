"""Drawing objects: points, lines, triangles and the like that scripts draw into the scene.

This module does not draw. It keeps the state for programs that show the scene: `DrawingObjects.shown` returns every
object with its current items in the world, and `version` changes with every change. Sensors do not see the objects.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import IDENTITY, Pose, add, inverse, multiply, rotate
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

POINTS, LINES, TRIANGLES, TRIANGLE_POINTS, QUAD_POINTS, DISC_POINTS, CUBE_POINTS, SPHERES, STRIP = range(9)
"""`sim_drawing_*` of V-REP 3, and the line strip of CoppeliaSim 4."""

_LAST_KIND = 12
"""Kinds 9 to 12 are CoppeliaSim 4's triangles, quads, discs and cubes, whose items have a quaternion."""

_KIND_BITS = 0x1F
ITEM_COLORS, VERTEX_COLORS, ITEM_SIZES = 0x20, 0x40, 0x80
CYCLIC, FACING_CAMERA, ITEM_TRANSPARENCY, LOCAL = 0x1000, 0x20000, 0x80000, 0x800000
"""Flags that are added to the kind."""

FIRST_HANDLE = 1
_MOST_ITEMS = 100_000
"""Most items of an object that is created without a limit."""

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Layout:
    """The meaning of the numbers of an item, in this order."""

    points: int
    has_normal: bool
    has_quaternion: bool
    extras: int
    """Number of values for colours, size and transparency."""

    @cached_property
    def size(self) -> int:
        """Return the number of values per item."""
        return 3 * self.points + 3 * self.has_normal + 4 * self.has_quaternion + self.extras

    @classmethod
    @lru_cache(maxsize=64)
    def of(cls, flags: int) -> Layout:
        """Return the layout for kind and flags. Raises CommandError for an unknown kind."""
        kind = flags & _KIND_BITS
        if kind > _LAST_KIND:
            raise CommandError(
                f"{kind} is no kind of drawing object; those are 0 to {_LAST_KIND} (sim.drawing_*)"
            )
        points = {LINES: 2, TRIANGLES: 3}.get(kind, 1)
        directed = not flags & FACING_CAMERA
        extras = 3 * bool(flags & ITEM_COLORS) + 3 * points * bool(flags & VERTEX_COLORS)
        extras += bool(flags & ITEM_SIZES) + bool(flags & ITEM_TRANSPARENCY)
        old = TRIANGLE_POINTS <= kind <= CUBE_POINTS
        return cls(points, old and directed, kind > STRIP and directed, extras)

    def moved(self, pose: Pose, item: Sequence[float]) -> tuple[float, ...]:
        """Return an item in another frame, in which `pose` is the pose of the item's frame."""
        position, quat = pose
        found: list[float] = []
        for start in range(0, 3 * self.points, 3):
            found += add(position, rotate(quat, item[start : start + 3]))
        rest = 3 * self.points
        if self.has_normal:
            found += rotate(quat, item[rest : rest + 3])
        if self.has_quaternion:
            own = frames.wxyz_from_xyzw(item[rest : rest + 4])
            found += frames.xyzw_from_wxyz(multiply(quat, own))
        return (*found, *item[len(found) :])

    def unmoved(self, item: Sequence[float]) -> tuple[float, ...]:
        """Return an item as `moved` does for the same frame."""
        if self.has_normal or self.has_quaternion:
            return self.moved(IDENTITY, item)
        places = 3 * self.points
        return (*[0.0 + each for each in item[:places]], *item[places:])  # no -0.0


@dataclass(eq=False)
class DrawingObject:
    """One drawing object; its items are kept in the frame of its parent."""

    handle: int
    flags: int
    """Kind and flags as given."""
    size: float
    """Size in pixels for points and lines, else in metres."""
    tolerance: float
    """Distance in metres; an item nearer to another one is not added. 0: no such check."""
    parent: int
    """Handle of the object that it moves with, -1 for the world."""
    most: int
    """Most items that it holds."""
    color: Color
    specular: Color
    emission: Color
    outlives_run: bool
    items: list[tuple[float, ...]] = field(default_factory=list[tuple[float, ...]])
    oldest: int = 0
    """Index of the item that a cyclic object overwrites next."""

    @property
    def kind(self) -> int:
        return self.flags & _KIND_BITS

    @cached_property
    def layout(self) -> Layout:
        return Layout.of(self.flags)

    def put(self, item: tuple[float, ...]) -> bool:
        """Add an item in the parent's frame; return False for a duplicate, and when it is full and not cyclic."""
        if self.tolerance > 0 and any(self._is_near(item, other) for other in self.items):
            return False
        if len(self.items) < self.most:
            self.items.append(item)
        elif self.flags & CYCLIC:
            self.items[self.oldest] = item
            self.oldest = (self.oldest + 1) % self.most
        else:
            return False
        return True

    def clear(self) -> None:
        """Remove all items."""
        self.items.clear()
        self.oldest = 0

    def _is_near(self, item: Sequence[float], other: Sequence[float]) -> bool:
        count = 3 * self.layout.points
        return math.dist(item[:count], other[:count]) < self.tolerance


def _pieces(numbers: Sequence[float], size: int) -> list[Sequence[float]]:
    return [numbers[start : start + size] for start in range(0, len(numbers), size)]


class DrawingObjects(Part):
    """All drawing objects. The end of a run removes those of the run that are not to outlive it; an object disappears
    with its scene or parent.
    """

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._objects: dict[int, DrawingObject] = {}
        self._next = FIRST_HANDLE
        self.version = 0
        """Number that changes whenever something is drawn or removed."""

    def __contains__(self, handle: int) -> bool:
        drawn = self._objects.get(handle)
        return drawn is not None and self._is_present(drawn)

    def run_stopped(self) -> None:
        self._objects = {handle: each for handle, each in self._objects.items() if each.outlives_run}
        self.version += 1

    def scene_changed(self) -> None:
        self.remove_all()

    def create(
        self,
        flags: int,
        size: float,
        tolerance: float,
        parent: int,
        most: int,
        color: Color = (1.0, 1.0, 1.0),
        specular: Color = (0.0, 0.0, 0.0),
        emission: Color = (0.0, 0.0, 0.0),
        *,
        outlives_run: bool = False,
    ) -> int:
        """Create an object and return its handle. `most`: 0 for the largest number of items allowed.

        Raises UnknownHandle, CommandError.
        """
        Layout.of(flags)
        if parent != -1:
            self._sim.scene.get(parent)
        if not 0 <= most <= _MOST_ITEMS:
            raise CommandError(
                f"a drawing object holds 1 to {_MOST_ITEMS} items, or 0 for the most; not {most}"
            )
        self._sim.limits.check("drawings", len(self._present()) + 1, "remove some")
        handle, self._next = self._next, self._next + 1
        self._objects[handle] = DrawingObject(
            handle,
            flags,
            size,
            max(0.0, tolerance),
            parent,
            most or _MOST_ITEMS,
            color,
            specular,
            emission,
            outlives_run,
        )
        self.version += 1
        return handle

    def draw(self, handle: int, numbers: Sequence[float]) -> bool:
        """Add items from their numbers, given in the world frame (with LOCAL in the parent's).

        Returns:
            False if any item was not added.

        Raises:
            CommandError: unknown handle, or not a whole number of items.
        """
        drawn = self.get(handle)
        layout = drawn.layout
        if not numbers or len(numbers) % layout.size:
            raise CommandError(
                f"an item of drawing object {handle} is {layout.size} numbers; got {len(numbers)}"
            )
        size = layout.size
        items = [numbers] if len(numbers) == size else _pieces(numbers, size)
        if drawn.flags & LOCAL or drawn.parent == -1:
            moved = [layout.unmoved(item) for item in items]
        else:
            pose = inverse(self._pose(drawn))
            moved = [layout.moved(pose, item) for item in items]
        done = list(map(drawn.put, moved))
        self.version += 1
        return all(done)

    def clear(self, handle: int) -> None:
        """Remove all items of an object. Raises CommandError."""
        self.get(handle).clear()
        self.version += 1

    def remove(self, handle: int) -> None:
        """Remove an object. Raises CommandError."""
        self.get(handle)
        del self._objects[handle]
        self.version += 1

    def remove_all(self) -> None:
        """Remove every object."""
        self._objects.clear()
        self.version += 1

    def get(self, handle: int) -> DrawingObject:
        """Return an object. Raises CommandError."""
        drawn = self._objects.get(handle)
        if drawn is None or not self._is_present(drawn):
            known = ", ".join(map(str, self._present())) or "none"
            raise CommandError(f"no drawing object with handle {handle}; there are {known}")
        return drawn

    def shown(self, most: int = sys.maxsize) -> list[tuple[DrawingObject, list[tuple[float, ...]]]]:
        """Return every object with its items in the world frame, at most `most` items in total."""
        found: list[tuple[DrawingObject, list[tuple[float, ...]]]] = []
        left = most
        for drawn in self._present().values():
            items = drawn.items[-left:] if left else []
            left -= len(items)
            if drawn.parent != -1:
                pose, layout = self._pose(drawn), drawn.layout
                items = [layout.moved(pose, item) for item in items]
            found.append((drawn, items))
        return found

    @property
    def are_carried(self) -> bool:
        """Return whether any object moves with a parent, so that `shown` may change without a new version."""
        return any(drawn.parent != -1 for drawn in self._present().values())

    def _present(self) -> dict[int, DrawingObject]:
        return {handle: each for handle, each in self._objects.items() if self._is_present(each)}

    def _is_present(self, drawn: DrawingObject) -> bool:
        """Return whether the object with which it moves still exists."""
        return drawn.parent == -1 or drawn.parent in self._sim.scene.objects

    def _pose(self, drawn: DrawingObject) -> Pose:
        return IDENTITY if drawn.parent == -1 else frames.get_pose(self._sim, drawn.parent)
