"""The frames of a scene, and where they are: those that physics moves, and those that it does not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.scene.poses.placing import object_pose
from simx_server.scene.poses.poses import IDENTITY, Pose, compose, from_rows, inverse
from simx_server.simulation.simulation import Simulation

from ..annotated.notes import Names, annotated, note_of, turn_of
from ..annotated.odometry import Odometers
from ..robots import Robots
from .naming import WORLD, frame_name

ATTACHED = (
    ObjectKind.DUMMY,
    ObjectKind.PROXIMITY_SENSOR,
    ObjectKind.VISION_SENSOR,
    ObjectKind.FORCE_SENSOR,
)
"""Kinds of objects that are frames, apart from bodies."""

_OPTICAL: Pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
"""The optical frame in that of the vision sensor, which looks along z with y up: half a turn about z."""

_ALONG_X: Pose = ((0.0, 0.0, 0.0), (math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0))
"""The frame of a range in that of its sensor, which looks along z: x is along the axis."""

_PRODUCT = np.zeros((4, 4, 4))
"""Factor of a[i] b[j] in component k of the product of a's conjugate and b: quaternions w, x, y, z."""

for _k, _row in enumerate(
    (
        ((0, 0, 1), (1, 1, 1), (2, 2, 1), (3, 3, 1)),
        ((0, 1, 1), (1, 0, -1), (2, 3, -1), (3, 2, 1)),
        ((0, 2, 1), (2, 0, -1), (3, 1, -1), (1, 3, 1)),
        ((0, 3, 1), (3, 0, -1), (1, 2, -1), (2, 1, 1)),
    )
):
    for _i, _j, _sign in _row:
        _PRODUCT[_k, _i, _j] = _sign


class Frame(NamedTuple):
    """A frame below another one."""

    name: str
    parent: str
    body: int
    """MuJoCo id of the body that it belongs to."""

    parent_body: int
    """That of the parent; 0 is the world."""


class Fixed(NamedTuple):
    """A frame that physics does not move against its parent, and where both are in the world."""

    frame: Frame
    pose: Callable[[], Pose]
    parent: Callable[[], Pose]


_LASER: Pose = ((0.0, 0.0, 0.0), from_rows(((0, -1, 0), (0, 0, -1), (1, 0, 0))))
"""The frame of a laser scan, x forward and z up, in an optical frame."""


class FrameTree:
    """The frames of a scene with one model."""

    def __init__(
        self,
        simulation: Simulation,
        odometers: Odometers,
        robots: Robots,
        is_row: Callable[[int], bool],
    ) -> None:
        """List the frames.

        Args:
            is_row: returns whether a vision sensor has one row, so that it is a laser scanner too.
        """
        self._is_row = is_row
        self._simulation = simulation
        self._model = simulation.model
        self._odometers = odometers
        self._bases = {base.item.body: base for base in odometers.bases}
        """Mobile bases by the body that carries them."""

        self._robots = robots
        self._names = Names(simulation.scene, robots)
        self._root = str(simulation.scene.annotations.ros2.get("root", WORLD))
        self.moving: list[Frame] = []
        """Bodies that physics moves against their parents."""

        self._fixed: list[Fixed] = []
        """Frames that it does not."""

        names = self._bodies()
        for frame, item in [*self._frames_of_bodies(names)]:
            base = self._bases.get(frame.body)
            if base is not None:
                # The frame of the base carries that of its body, and moves in its odometry frame.
                place = partial(odometers.pose, base)
                self._fixed.append(Fixed(frame._replace(parent=base.frame), self._pose_of(item), place))
            elif _moves(self._model, frame.body, frame.parent_body):
                self.moving.append(frame)
            else:
                self._fixed.append(self._fixed_in_body(frame, item))
        self._add_attached(names)
        self._add_annotated(names)
        self._ids = np.array([frame.body for frame in self.moving], np.intp)
        self._parents = np.array([frame.parent_body for frame in self.moving], np.intp)

    def poses(self) -> NDArray[np.float64]:
        """Return (n, 7): position in metres and quaternion x, y, z, w of each moving frame in its parent."""
        self._simulation.refresh()  # something may have been placed elsewhere since the last step
        data, ids, parents = self._simulation.data, self._ids, self._parents
        found = np.empty((len(ids), 7))
        turn = data.xmat[parents].reshape(-1, 3, 3)
        np.einsum("nji,nj->ni", turn, data.xpos[ids] - data.xpos[parents], out=found[:, :3])
        quaternion = np.einsum("kij,ni,nj->nk", _PRODUCT, data.xquat[parents], data.xquat[ids])
        found[:, 3:6], found[:, 6] = quaternion[:, 1:], quaternion[:, 0]
        return found

    def fixed_transforms(self) -> list[Mapping[str, Any]]:
        """Return the transforms of the other frames, without stamps."""
        self._simulation.refresh()
        found: list[Mapping[str, Any]] = []
        for frame, pose, parent in self._fixed:
            (x, y, z), (w, *xyz) = compose(inverse(parent()), pose())
            found.append(transform(frame, (x, y, z, *xyz, w)))
        return found

    def _fixed_in_body(self, frame: Frame, item: SceneObject, turn: Pose = IDENTITY) -> Fixed:
        """Return a frame of an object, turned against it, below the frame of a body or of the world."""
        return Fixed(frame, self._pose_of(item, turn), partial(self._pose_of_body, frame.parent_body))

    def _pose_of(self, item: SceneObject, turn: Pose = IDENTITY) -> Callable[[], Pose]:
        simulation, handle = self._simulation, item.handle
        return lambda: compose(object_pose(simulation, simulation.scene.objects[handle]), turn)

    def _pose_of_body(self, body: int) -> Pose:
        data = self._simulation.data
        return (_floats(data.xpos[body]), _floats(data.xquat[body])) if body else IDENTITY

    def _bodies(self) -> dict[int, str]:
        """Return the frame of each body that is one."""
        scene = self._simulation.scene
        return {
            item.id: frame_name(item)
            for item in scene.objects.values()
            if item.element == "body" and item.id > 0
        }

    def _frames_of_bodies(self, names: Mapping[int, str]) -> Iterator[tuple[Frame, SceneObject]]:
        for item in self._simulation.scene.objects.values():
            if item.element == "body" and item.id in names:
                above = self._nearest(names, int(self._model.body_parentid[item.id]))
                yield Frame(names[item.id], names.get(above, self._root), item.id, above), item

    def _add_attached(self, names: Mapping[int, str]) -> None:
        for item in self._simulation.scene.objects.values():
            if item.kind not in ATTACHED or item.element not in ("site", "camera"):
                continue
            above = self._nearest(names, item.body)
            frame = Frame(frame_name(item), names.get(above, self._root), item.body, above)
            self._fixed.append(self._fixed_in_body(frame, item))
            if item.element == "camera":
                optical = frame._replace(name=self._names.camera_frame(item, note_of(item)))
                self._fixed.append(self._fixed_in_body(optical, item, _OPTICAL))
                if item.kind is ObjectKind.VISION_SENSOR and self._is_row(item.handle):
                    laser = frame._replace(name=self._names.laser_frame(item))
                    self._fixed.append(self._fixed_in_body(laser, item, compose(_OPTICAL, _LASER)))

    def _add_annotated(self, names: Mapping[int, str]) -> None:
        """Add the frames that annotations name: of bases, scans, IMUs and ranges."""
        for base in self._odometers.bases:
            if base.parent:
                frame = Frame(base.odom, base.parent, 0, 0)
                self._fixed.append(
                    Fixed(frame, partial(self._odometers.start, base), partial(self._pose_of_body, 0))
                )
        for item, note in annotated(self._simulation.scene, self._robots, "frame", "range"):
            if item.element == "camera":
                continue
            above = self._nearest(names, item.body)
            parent = names.get(above, self._root)
            if "range" in note:
                frame = Frame(self._names.range_frame(item, note), parent, item.body, above)
                self._fixed.append(self._fixed_in_body(frame, item, _ALONG_X))
            else:
                frame = Frame(self._names.header_frame(item, note), parent, item.body, above)
                self._fixed.append(self._fixed_in_body(frame, item, ((0.0, 0.0, 0.0), turn_of(note))))

    def _nearest(self, names: Mapping[int, str], body: int) -> int:
        """Return the body itself or the nearest one above that is a frame; 0 for the world."""
        while body > 0 and body not in names:
            body = int(self._model.body_parentid[body])
        return body


def transform(frame: Frame, values: Sequence[float]) -> dict[str, Any]:
    """Return a ``geometry_msgs/TransformStamped`` without its stamp.

    Args:
        values: position and quaternion x, y, z, w.
    """
    px, py, pz, x, y, z, w = values
    return {
        "header": {"frame_id": frame.parent},
        "child_frame_id": frame.name,
        "transform": {
            "translation": {"x": px, "y": py, "z": pz},
            "rotation": {"x": x, "y": y, "z": z, "w": w},
        },
    }


def _moves(model: mujoco.MjModel, body: int, parent: int) -> bool:
    """Return whether physics or a call moves a body against one above it."""
    if model.body_weldid[body] != model.body_weldid[parent]:
        return True
    while body > 0 and body != parent:
        if model.body_mocapid[body] >= 0:
            return True
        body = int(model.body_parentid[body])
    return False


def _floats(values: NDArray[np.float64]) -> Any:
    return tuple(values.tolist())
