"""The positions with which a scene starts where they are not those of its bodies in the file.

A keyframe `simx:start` has them; saved scenes have one. MuJoCo's reference positions stay those of the file, so that
everything that is computed from them stays as it was. The turns of spherical joints may also stand in annotations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.scene.formats.annotations import PREFIX, SceneError

KEY = PREFIX + "start"
"""Name of the keyframe."""

Numbers = NDArray[np.float64]

_SIZES = (7, 4, 1, 1)
"""Number of position values of a free, ball, slide and hinge joint."""


@dataclass(frozen=True)
class Start:
    """First positions by the names of elements."""

    joints: Mapping[str, Numbers] = field(default_factory=dict[str, Numbers])
    """Position values of each joint, as MuJoCo has them: 7 of a free one, 4 of a ball, 1."""

    mocap: Mapping[str, Numbers] = field(default_factory=dict[str, Numbers])
    """Position and quaternion of each mocap body."""

    def renamed(self, prefix: str) -> Start:
        """Return the same for elements whose names have got a prefix."""
        return Start(
            *({prefix + name: each for name, each in part.items()} for part in (self.joints, self.mocap))
        )

    def put_into(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Write the positions into a state, as far as the model has the elements."""
        for name, values in self.joints.items():
            joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
            if joint >= 0:
                address = int(model.jnt_qposadr[joint])
                data.qpos[address : address + len(values)] = values
        for name, pose in self.mocap.items():
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
            place = int(model.body_mocapid[body]) if body >= 0 else -1
            if place >= 0:
                data.mocap_pos[place], data.mocap_quat[place] = pose[:3], pose[3:]


@dataclass(frozen=True)
class StartKey:
    """The numbers of the keyframe, in the order of a model; empty ones are those of the file."""

    qpos: Numbers
    mpos: Numbers
    mquat: Numbers

    @classmethod
    def take_from(cls, spec: mujoco.MjSpec) -> StartKey | None:
        """Remove the keyframe from a spec and return it; None without one."""
        key = spec.key(KEY)
        if key is None:
            return None
        found = cls(*(np.array(each, np.float64) for each in (key.qpos, key.mpos, key.mquat)))
        spec.delete(key)
        return found

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the keyframe to a spec."""
        spec.add_key(name=KEY, qpos=self.qpos, mpos=self.mpos, mquat=self.mquat)

    def of(self, model: mujoco.MjModel) -> Start:
        """Return the positions by name. Raises SceneError: the numbers do not fit the model."""
        wanted = {"qpos": model.nq, "mpos": 3 * model.nmocap, "mquat": 4 * model.nmocap}
        for name, count in wanted.items():
            numbers: Numbers = getattr(self, name)
            if len(numbers) not in (0, count) or not np.isfinite(numbers).all():
                raise SceneError(
                    f"key '{KEY}' has {len(numbers)} numbers in {name}; valid are {count} finite ones, or none"
                )
        joints = range(model.njnt) if len(self.qpos) else ()
        bodies = (
            np.flatnonzero(model.body_mocapid >= 0).tolist() if len(self.mpos) and len(self.mquat) else ()
        )
        starts = model.jnt_qposadr
        return Start(
            {model.joint(j).name: self.qpos[starts[j] :][: _SIZES[model.jnt_type[j]]] for j in joints},
            {model.body(b).name: self._mocap(int(model.body_mocapid[b])) for b in bodies},
        )

    def _mocap(self, place: int) -> Numbers:
        position, quat = self.mpos[3 * place :][:3], self.mquat[4 * place :][:4]
        length = float(np.linalg.norm(quat))
        return np.concatenate((position, quat / length if length else (1.0, 0.0, 0.0, 0.0)))
