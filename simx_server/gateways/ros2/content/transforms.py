"""``/tf`` and ``/tf_static``: where the scene's bodies, dummies and sensors are.

Each body with an object is a frame, below the nearest body above it that is one, or below `world`. Dummies, sensors and
optical frames of vision sensors are below their body. What physics moves against its parent is in ``/tf``, the rest in
``/tf_static``, which is sent again when something was placed elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.geometry.placing import element_pose, object_pose
from simx_server.scene.geometry.poses import IDENTITY, Pose, compose, inverse
from simx_server.scene.objects import ObjectKind, SceneObject
from simx_server.world.simulation import Simulation

from ..endpoints import Content, Context, Message, Moment, Offer, Published
from ..wire.qos import LATCHED, TRANSFORMS
from .naming import WORLD, frame_name, optical_frame

TYPE = "tf2_msgs/msg/TFMessage"

ATTACHED = (
    ObjectKind.DUMMY,
    ObjectKind.PROXIMITY_SENSOR,
    ObjectKind.VISION_SENSOR,
    ObjectKind.FORCE_SENSOR,
)
"""Kinds of objects that are frames although they are no bodies."""

_OPTICAL: Pose = ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
"""The optical frame in that of MuJoCo's camera, which looks along -z with y up: half a turn about x."""

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


class Transforms(Content):
    """Publishes the transforms of the present scene."""

    def __init__(self, context: Context) -> None:
        self._simulation = context.world.simulation
        self._tree = FrameTree(self._simulation)
        self._seen: tuple[object, int] = (None, -1)
        """Model and its version when the static transforms were last compared."""

        self._sent: list[Mapping[str, Any]] | None = None
        """The static transforms that were sent last."""

    def offers(self) -> Iterable[Offer]:
        self._tree = FrameTree(self._simulation)
        self._seen = None, -1
        yield Published("/tf", TYPE, self._moving, TRANSFORMS, repeats=False)
        yield Published("/tf_static", TYPE, self._static, LATCHED)

    def _moving(self, moment: Moment) -> Message | None:
        if not self._tree.moving:
            return None
        return {"transforms": list(stamped(self._tree.moving, self._tree.poses(), moment))}

    def _static(self, moment: Moment) -> Message | None:
        seen = self._simulation.model, self._simulation.model_version
        if seen == self._seen:
            return None
        self._seen = seen
        transforms = self._tree.fixed_transforms()
        if transforms == self._sent:
            return None
        self._sent = transforms
        header = moment.header(WORLD)
        return {"transforms": [{**each, "header": {**header, **each["header"]}} for each in transforms]}


class FrameTree:
    """The frames of a scene with one model."""

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        self._model = simulation.model
        self.moving: list[Frame] = []
        """Bodies that physics moves against their parents."""

        self._fixed: list[tuple[Frame, SceneObject, bool]] = []
        """Frames that it does not, with their objects, and whether they are optical ones."""

        names = self._bodies()
        for frame, item in [*self._frames_of_bodies(names)]:
            if _moves(self._model, frame.body, frame.parent_body):
                self.moving.append(frame)
            else:
                self._fixed.append((frame, item, False))
        self._add_attached(names)
        self._ids = np.array([frame.body for frame in self.moving], np.intp)
        self._parents = np.array([frame.parent_body for frame in self.moving], np.intp)

    def poses(self) -> NDArray[np.float64]:
        """Return (n, 7): position in metres and quaternion x, y, z, w of each moving frame in its parent."""
        data, ids, parents = self._simulation.data, self._ids, self._parents
        found = np.empty((len(ids), 7))
        turn = data.xmat[parents].reshape(-1, 3, 3)
        np.einsum("nji,nj->ni", turn, data.xpos[ids] - data.xpos[parents], out=found[:, :3])
        quaternion = np.einsum("kij,ni,nj->nk", _PRODUCT, data.xquat[parents], data.xquat[ids])
        found[:, 3:6], found[:, 6] = quaternion[:, 1:], quaternion[:, 0]
        return found

    def fixed_transforms(self) -> list[Mapping[str, Any]]:
        """Return the transforms of the other frames, without stamps."""
        simulation = self._simulation
        simulation.refresh()
        found: list[Mapping[str, Any]] = []
        for frame, item, is_optical in self._fixed:
            pose = (
                compose(element_pose(simulation, item), _OPTICAL)
                if is_optical
                else object_pose(simulation, item)
            )
            data, body = simulation.data, frame.parent_body
            parent: Pose = (_floats(data.xpos[body]), _floats(data.xquat[body])) if body else IDENTITY
            (x, y, z), (w, *xyz) = compose(inverse(parent), pose)
            found.append(transform(frame, (x, y, z, *xyz, w)))
        return found

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
                yield Frame(names[item.id], names.get(above, WORLD), item.id, above), item

    def _add_attached(self, names: Mapping[int, str]) -> None:
        for item in self._simulation.scene.objects.values():
            if item.kind not in ATTACHED or item.element not in ("site", "camera"):
                continue
            above = self._nearest(names, item.body)
            frame = Frame(frame_name(item), names.get(above, WORLD), item.body, above)
            self._fixed.append((frame, item, False))
            if item.element == "camera":
                self._fixed.append((frame._replace(name=optical_frame(item)), item, True))

    def _nearest(self, names: Mapping[int, str], body: int) -> int:
        """Return the body itself or the nearest one above that is a frame; 0 for the world."""
        while body > 0 and body not in names:
            body = int(self._model.body_parentid[body])
        return body


def stamped(
    frames: Sequence[Frame], poses: NDArray[np.float64], moment: Moment
) -> Iterator[Mapping[str, Any]]:
    """Yield a transform of each frame.

    Args:
        poses: (n, 7) position and quaternion x, y, z, w.
    """
    for frame, values in zip(frames, poses.tolist(), strict=True):
        made = transform(frame, values)
        yield {**made, "header": moment.header(frame.parent)}


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
