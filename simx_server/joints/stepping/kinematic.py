"""Joints that physics does not move (held, in motion, following a master), and free joints put back."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from simx_server.joints.dependency import Followers
from simx_server.joints.profiles import Profiles
from simx_server.joints.servo import Entry, Rule

from .indices import Columns


class Kinematic:
    """Puts the joints where they belong after every physics step, in arrays.

    Their inertia is huge (`weights.py`), so a physics step hardly changes their velocity.

    Also puts back free joints that are rewound: they turn at the velocity that physics gives them, but stay in
    place. So the rollers around a mecanum wheel always lie as the roller on the floor does.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, entries: Sequence[Entry]) -> None:
        still = [b for b, _, r in entries if r == Rule.KINEMATIC]
        self._still_qpos = np.array([b.qpos + i for b in still for i in range(b.qpos_count)], dtype=np.intp)
        self._still_dof = np.array([b.dof + i for b in still for i in range(b.dof_count)], dtype=np.intp)
        self._still = data.qpos[self._still_qpos]
        moving = [(b, s) for b, s, r in entries if r == Rule.MOTION]
        self._moving_qpos = np.array([b.qpos for b, _ in moving], dtype=np.intp)
        self._moving_dof = np.array([b.dof for b, _ in moving], dtype=np.intp)
        self._moving = data.qpos[self._moving_qpos]
        self._rate = np.array([s.target_velocity for _, s in moving])
        self._step = model.opt.timestep
        limits = [
            model.jnt_range[b.id] if model.jnt_limited[b.id] else (-math.inf, math.inf) for b, _ in moving
        ]
        self._low, self._high = np.array(limits, dtype=float).reshape(-1, 2).T.copy()
        self._followers = Followers(model, entries, Rule.DEPENDENT)
        rewound = [b.qpos for b, s, r in entries if s.rewind and r == Rule.FREE and b.kind != "ball"]
        self._rewound = np.array(rewound, dtype=np.intp)
        self._start = model.qpos0[self._rewound]
        self._profiles = Profiles(model, data, entries)
        self._exists = bool(still or moving or rewound or self._followers or self._profiles)
        if moving:
            # Contacts of the first physics step must feel the velocity too.
            data.qvel[self._moving_dof] = self._rate

    def __bool__(self) -> bool:
        return self._exists

    @property
    def needs_python(self) -> bool:
        """Return whether a motion profile moves a joint, which the compiled form does not know."""
        return bool(self._profiles)

    @property
    def columns(self) -> Columns:
        """Return the arrays by name, for the compiled form."""
        return {
            "still.qpos": self._still_qpos,
            "still.value": self._still,
            "still.dof": self._still_dof,
            "moving.qpos": self._moving_qpos,
            "moving.dof": self._moving_dof,
            "moving.value": self._moving,
            "moving.rate": self._rate,
            "moving.low": self._low,
            "moving.high": self._high,
            "rewound.qpos": self._rewound,
            "rewound.start": self._start,
            **{f"follower.{name}": values for name, values in self._followers.columns.items()},
        }

    def hold(self, data: mujoco.MjData) -> None:
        """Undo the effect of the physics step on them."""
        data.qpos[self._still_qpos] = self._still
        data.qvel[self._still_dof] = 0.0
        data.qpos[self._rewound] = self._start
        if self._moving.size:
            before = self._moving.copy()
            self._moving[:] = np.clip(before + self._rate * self._step, self._low, self._high)
            data.qpos[self._moving_qpos] = self._moving
            data.qvel[self._moving_dof] = (self._moving - before) / self._step
        if self._profiles:
            self._profiles.advance(data)
        if self._followers:
            self._followers.follow(data)
