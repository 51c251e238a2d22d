"""Carry a simulation's state from one compiled model to its edited successor, by the names of the elements."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import mujoco
import numpy as np

from simx_server.scene.geometry.highlights import highlights_of

from .model_state import option_values
from .twins import Twins

_ARRAYS = (
    *("body_pos", "body_quat", "body_ipos", "body_iquat", "body_mass", "body_inertia"),
    *("geom_pos", "geom_quat", "geom_size", "geom_rgba", "geom_friction", "geom_contype"),
    *("geom_solref", "geom_solimp", "geom_solmix", "geom_margin", "geom_condim", "geom_priority"),
    *("geom_conaffinity", "geom_group", "site_pos", "site_quat", "site_rgba", "site_size"),
    *(
        "cam_mode",
        "cam_pos",
        "cam_quat",
        "cam_fovy",
        "cam_resolution",
        "light_mode",
        "light_pos",
        "light_dir",
    ),
    *(
        "light_active",
        "light_diffuse",
        "light_ambient",
        "light_specular",
        "light_attenuation",
        "light_cutoff",
    ),
    *("light_exponent", "light_castshadow", "jnt_range", "jnt_limited"),
    *("jnt_pos", "jnt_axis"),
    *("jnt_stiffness", "tendon_range", "tendon_limited", "mat_rgba", "mat_emission", "mat_specular"),
)
"""Model arrays of settings a command may have written. The joints write the actuators' arrays themselves.

Which elements have the frame of their body follows from these: `mj_setConst` finds it again where one differs.
"""

_PLACES = ("_pos", "_quat", "_dir", "_mode")
"""Endings of the names of arrays that say where an element is."""

_INERTIA = ("body_ipos", "body_iquat", "body_mass", "body_inertia")

_ARRAYS_OF = {
    prefix: [
        # Nothing writes the sizes of geoms but edits, which also say that these are moved.
        (array, array.endswith(_PLACES) or array == "geom_size", array in _INERTIA)
        for array in _ARRAYS
        if array.startswith(prefix)
    ]
    for prefix in dict.fromkeys(array[: array.index("_") + 1] for array in _ARRAYS)
}
"""The arrays by the prefix of their kind of element; which of them say where it is, and which are inertia."""

_POSITIONS = np.array((7, 4, 1, 1))
_DOFS = np.array((6, 3, 1, 1))
"""Number of degrees of freedom by type of joint."""


def carry_over(
    old_model: mujoco.MjModel,
    old_data: mujoco.MjData,
    new_model: mujoco.MjModel,
    new_data: mujoco.MjData,
    twins: Twins,
    moved: Collection[tuple[str, str]] = (),
    reweighed: Collection[str] = (),
    copies: Collection[str] = (),
) -> bool:
    """Give the new model the edited settings and the new data the state of the old ones.

    Args:
        moved: (array prefix, element name) of elements with a new place, which keep the new model's local pose.
        reweighed: names of bodies that keep the new model's inertia.
        copies: prefixes of new elements that start as copies of those with the same name without it.

    Returns:
        Whether any setting in the new model differs from the compiled one.
    """
    differs = False
    placed = {prefix: {name for kind, name in moved if kind == prefix} for prefix, _ in moved}
    for prefix, arrays in _ARRAYS_OF.items():
        old, new = twins.pairs(prefix[:-1], copies)
        if not len(new):
            continue
        all_old, all_new = _span(old), _span(new)
        own_place = _among(twins, prefix[:-1], new, placed.get(prefix, ()))
        own_weight = _among(twins, prefix[:-1], new, reweighed) if prefix == "body_" else None
        if prefix == "body_":  # bodies that an edit has left without any mass get some, to stay movable
            gained = (old_model.body_mass[old] == 0) & (new_model.body_mass[new] > 0)
            if gained.any():
                own_weight = gained if own_weight is None else own_weight | gained
        for array, is_place, is_inertia in arrays:
            keeps = own_place if is_place else None
            if is_inertia and own_weight is not None:
                keeps = own_weight if keeps is None else keeps | own_weight
            source, target = getattr(old_model, array), getattr(new_model, array)
            here, there = (all_old, all_new) if keeps is None else (old[~keeps], new[~keeps])
            values = source[here]
            if target[there].tobytes() != values.tobytes():
                target[there] = values
                differs = True
    _unmark_simple(new_model)
    differs |= _carry_highlights(old_model, new_model)
    differs |= not _are_equal(option_values(old_model.opt), option_values(new_model.opt))
    new_model.opt = old_model.opt
    differs |= _carry_joints(old_model, old_data, new_model, new_data, *twins.pairs("jnt", copies))
    _carry_bodies(old_model, old_data, new_model, new_data, twins, placed.get("body_", ()), copies)
    _carry_actuators(old_model, old_data, new_model, new_data, *twins.pairs("actuator", copies))
    old, new = twins.pairs("eq", copies)
    new_data.eq_active[new] = old_data.eq_active[old]
    if new_model.nuserdata == old_model.nuserdata:
        new_data.userdata[:] = old_data.userdata
    new_data.time = old_data.time
    return differs


def _carry_highlights(old_model: mujoco.MjModel, new_model: mujoco.MjModel) -> bool:
    """Give the new model the colours of highlights; return whether one differs from the compiled one."""
    differs, old = False, highlights_of(old_model)
    for material, color in highlights_of(new_model).items():
        before = mujoco.mj_name2id(old_model, mujoco.mjtObj.mjOBJ_MATERIAL, new_model.material(material).name)
        if before in old and not np.array_equal(old[before], color):
            color[:] = old[before]
            differs = True
    return differs


def _unmark_simple(model: mujoco.MjModel) -> None:
    """Remove the simple mark of fixed bodies whose inertia was carried to another place, which MuJoCo refuses.

    A body with joints keeps the mark, because the layout of its matrices depends on it.
    """
    is_fixed = (model.body_simple > 0) & (model.body_dofnum == 0)
    is_apart = (model.body_ipos != 0).any(1) | (model.body_iquat[:, 1:] != 0).any(1)
    model.body_simple[is_fixed & is_apart] = 0


def _among(twins: Twins, kind: str, ids: np.ndarray, wanted: Collection[str]) -> np.ndarray | None:
    """Return which of these ids of the new model have one of the names; None without names."""
    if not wanted:
        return None
    return np.isin(ids, [twins.new.find(kind, name) for name in wanted])


def _span(ids: np.ndarray) -> Any:
    """Return consecutive ids as a slice, which avoids a copy of the elements."""
    first, last = int(ids[0]), int(ids[-1])
    return slice(first, last + 1) if (np.diff(ids) == 1).all() else ids


def _are_equal(options: dict[str, Any], others: dict[str, Any]) -> bool:
    return all(
        np.asarray(value).tobytes() == np.asarray(others[name]).tobytes() for name, value in options.items()
    )


def _carry_joints(
    old_model: Any, old_data: Any, new_model: Any, new_data: Any, old: np.ndarray, new: np.ndarray
) -> bool:
    """Carry the state of joints and their damping; return whether this differs from the compiled one."""
    if not len(old):
        return False
    kinds = old_model.jnt_type[old]
    source, target = _runs(old_model.jnt_qposadr[old], new_model.jnt_qposadr[new], _POSITIONS[kinds])
    new_data.qpos[target] = old_data.qpos[source]
    source, target = _runs(old_model.jnt_dofadr[old], new_model.jnt_dofadr[new], _DOFS[kinds])
    for name in ("qvel", "qacc_warmstart", "qfrc_applied"):
        getattr(new_data, name)[target] = getattr(old_data, name)[source]
    differs = not np.array_equal(new_model.dof_damping[target], old_model.dof_damping[source])
    if differs:
        new_model.dof_damping[target] = old_model.dof_damping[source]
    return differs


def _carry_bodies(
    old_model: Any,
    old_data: Any,
    new_model: Any,
    new_data: Any,
    twins: Twins,
    placed: Collection[str],
    copies: Collection[str],
) -> None:
    old, new = twins.pairs("body", copies)
    new_data.xfrc_applied[new] = old_data.xfrc_applied[old]
    if not old_model.nmocap:
        return
    own_place = _among(twins, "body", new, placed)
    mocap, twin = old_model.body_mocapid[old], new_model.body_mocapid[new]
    carried = (mocap >= 0) & (twin >= 0)
    if own_place is not None:
        carried &= ~own_place
    new_data.mocap_pos[twin[carried]] = old_data.mocap_pos[mocap[carried]]
    new_data.mocap_quat[twin[carried]] = old_data.mocap_quat[mocap[carried]]


def _carry_actuators(
    old_model: Any, old_data: Any, new_model: Any, new_data: Any, old: np.ndarray, new: np.ndarray
) -> None:
    for name in ("ctrl", "act") if len(old) else ():
        counts = getattr(old_model, f"actuator_{name}num")[old]
        has = counts > 0
        source, target = _runs(
            getattr(old_model, f"actuator_{name}adr")[old][has],
            getattr(new_model, f"actuator_{name}adr")[new][has],
            counts[has],
        )
        getattr(new_data, name)[target] = getattr(old_data, name)[source]


def _runs(starts: np.ndarray, new_starts: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of runs of these lengths, and the indices of their destinations."""
    total = int(counts.sum())
    within = np.arange(total) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.repeat(starts, counts) + within, np.repeat(new_starts, counts) + within
