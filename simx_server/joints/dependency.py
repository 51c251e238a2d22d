"""Dependent joints: they follow their masters in arrays, and equalities carry the forces."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from .servo import Entry, Rule
from .state import Binding, JointMode, JointState


class Followers:
    """The joints of dependent mode that follow one rule, and where their masters want them."""

    def __init__(self, model: mujoco.MjModel, entries: Sequence[Entry], rule: Rule) -> None:
        by_handle = {binding.handle: (binding, state, r) for binding, state, r in entries}
        chosen = [
            (binding, state)
            for binding, state, r in entries
            if r == rule and state.mode == JointMode.DEPENDENT and state.master in by_handle
        ]
        leads = [_lead(state, by_handle) for _, state in chosen]
        self.handles = [binding.handle for binding, _ in chosen]
        self._qpos = np.array([binding.qpos for binding, _ in chosen], dtype=np.intp)
        self._dof = np.array([binding.dof for binding, _ in chosen], dtype=np.intp)
        self._lead_qpos = np.array([lead.qpos for lead, _, _ in leads], dtype=np.intp)
        self._lead_dof = np.array([lead.dof for lead, _, _ in leads], dtype=np.intp)
        self._factor = np.array([factor for _, factor, _ in leads])
        self._shift = np.array([shift for _, _, shift in leads])
        limits = [
            model.jnt_range[b.id] if model.jnt_limited[b.id] else (-math.inf, math.inf) for b, _ in chosen
        ]
        self._low, self._high = np.array(limits, dtype=float).reshape(-1, 2).T.copy()

    def __bool__(self) -> bool:
        return bool(self.handles)

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """Return the arrays by name, for the compiled form."""
        return {
            "qpos": self._qpos,
            "dof": self._dof,
            "lead_qpos": self._lead_qpos,
            "lead_dof": self._lead_dof,
            "factor": self._factor,
            "shift": self._shift,
            "low": self._low,
            "high": self._high,
        }

    def wanted(self, data: mujoco.MjData) -> np.ndarray:
        """Return the position per joint, rad or m, within its limits."""
        return np.clip(data.qpos[self._lead_qpos] * self._factor + self._shift, self._low, self._high)

    def follow(self, data: mujoco.MjData) -> None:
        """Move the joints to these positions, with the matching velocity."""
        data.qpos[self._qpos] = self.wanted(data)
        data.qvel[self._dof] = data.qvel[self._lead_dof] * self._factor


def write_equality(
    binding: Binding,
    state: JointState,
    rule: Rule,
    master: Binding | None,
    model: mujoco.MjModel,
    data: mujoco.MjData,
) -> None:
    """Couple a joint to its master, or decouple it; the master then feels a load on the joint.

    MuJoCo's joint equality counts both positions from the model's `qpos0`.
    """
    if binding.equality < 0:
        return
    active = rule == Rule.DEPENDENT and master is not None
    data.eq_active[binding.equality] = active
    if not active or master is None:
        return
    model.eq_obj2id[binding.equality] = master.id
    rest, master_rest = model.qpos0[binding.qpos], model.qpos0[master.qpos]
    model.eq_data[binding.equality, :5] = 0.0
    model.eq_data[binding.equality, 0] = state.shift - rest + state.factor * master_rest
    model.eq_data[binding.equality, 1] = state.factor


def _lead(state: JointState, by_handle: dict[int, Entry]) -> tuple[Binding, float, float]:
    """Return the first joint up the chain that follows no other, with factor and shift relative to it."""
    factor, shift = state.factor, state.shift
    lead, lead_state, rule = by_handle[state.master]
    while rule == Rule.DEPENDENT and lead_state.master in by_handle:
        factor, shift = factor * lead_state.factor, shift + factor * lead_state.shift
        lead, lead_state, rule = by_handle[lead_state.master]
    return lead, factor, shift
