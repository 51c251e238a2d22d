"""Carrying a simulation's state from one compiled model to its edited successor, by the names of the elements."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

import mujoco
import numpy as np

from simx_server.snapshot import option_values, write_options

_KINDS = {
    "body_": mujoco.mjtObj.mjOBJ_BODY,
    "geom_": mujoco.mjtObj.mjOBJ_GEOM,
    "site_": mujoco.mjtObj.mjOBJ_SITE,
    "cam_": mujoco.mjtObj.mjOBJ_CAMERA,
    "light_": mujoco.mjtObj.mjOBJ_LIGHT,
    "jnt_": mujoco.mjtObj.mjOBJ_JOINT,
    "tendon_": mujoco.mjtObj.mjOBJ_TENDON,
}

_ARRAYS = (
    *("body_pos", "body_quat", "body_ipos", "body_iquat", "body_mass", "body_inertia"),
    *("geom_pos", "geom_quat", "geom_sameframe", "geom_size", "geom_rgba", "geom_friction", "geom_contype"),
    *("geom_solref", "geom_solimp", "geom_solmix", "geom_margin", "geom_condim", "geom_priority"),
    *("geom_conaffinity", "geom_group", "site_pos", "site_quat", "site_sameframe", "site_rgba", "site_size"),
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
    *("light_active", "light_diffuse", "light_ambient", "light_specular", "jnt_range", "jnt_limited"),
    *("jnt_pos", "jnt_axis"),
    *("jnt_stiffness", "tendon_range", "tendon_limited"),
)
"""Model arrays of settings a command may have written. What belongs to actuators is written again by the joints."""

_INERTIA = ("body_ipos", "body_iquat", "body_mass", "body_inertia")

_JOINT_SIZES = {0: (7, 6), 1: (4, 3), 2: (1, 1), 3: (1, 1)}
"""Joint type to (positions, degrees of freedom)."""


def carry_over(
    old_model: mujoco.MjModel,
    old_data: mujoco.MjData,
    new_model: mujoco.MjModel,
    new_data: mujoco.MjData,
    moved: Collection[tuple[str, str]] = (),
    reweighed: Collection[str] = (),
    copies: str | None = None,
) -> None:
    """Give the new model the edited settings and the new data the state of the old ones.

    `moved`: (array prefix, element name) of what was placed anew, whose local pose is the new model's own.
    `reweighed`: names of bodies whose inertia is the new model's own.
    `copies`: prefix of new elements that start as copies of those named as they are without it.
    """
    twins = {prefix: list(_twins(old_model, new_model, kind, copies)) for prefix, kind in _KINDS.items()}
    for array in _ARRAYS:
        prefix = array[: array.index("_") + 1]
        source, target = getattr(old_model, array), getattr(new_model, array)
        for name, old, new in twins[prefix]:
            placed = (
                array.endswith(("_pos", "_quat", "_sameframe", "_dir", "_mode")) and (prefix, name) in moved
            )
            if not placed and not (array in _INERTIA and name in reweighed):
                target[new] = source[old]
    write_options(new_model, option_values(old_model))
    _carry_joints(old_model, old_data, new_model, new_data, twins["jnt_"])
    for name, old, new in twins["body_"]:
        new_data.xfrc_applied[new] = old_data.xfrc_applied[old]
        mocap, twin = int(old_model.body_mocapid[old]), int(new_model.body_mocapid[new])
        if mocap >= 0 and twin >= 0 and ("body_", name) not in moved:
            new_data.mocap_pos[twin] = old_data.mocap_pos[mocap]
            new_data.mocap_quat[twin] = old_data.mocap_quat[mocap]
    for _, old, new in _twins(old_model, new_model, mujoco.mjtObj.mjOBJ_ACTUATOR, copies):
        _copy_run(old_data.ctrl, new_data.ctrl, old_model.actuator_ctrladr[old], new_model.actuator_ctrladr[new],
                  old_model.actuator_ctrlnum[old])  # fmt: skip
        if old_model.actuator_actnum[old]:
            _copy_run(old_data.act, new_data.act, old_model.actuator_actadr[old], new_model.actuator_actadr[new],
                      old_model.actuator_actnum[old])  # fmt: skip
    for _, old, new in _twins(old_model, new_model, mujoco.mjtObj.mjOBJ_EQUALITY, copies):
        new_data.eq_active[new] = old_data.eq_active[old]
    if new_model.nuserdata == old_model.nuserdata:
        new_data.userdata[:] = old_data.userdata
    new_data.time = old_data.time


def _carry_joints(
    old_model: Any, old_data: Any, new_model: Any, new_data: Any, twins: list[tuple[str, int, int]]
) -> None:
    for _, old, new in twins:
        positions, dofs = _JOINT_SIZES[int(old_model.jnt_type[old])]
        _copy_run(
            old_data.qpos, new_data.qpos, old_model.jnt_qposadr[old], new_model.jnt_qposadr[new], positions
        )
        for name in ("qvel", "qacc_warmstart", "qfrc_applied"):
            source, target = getattr(old_data, name), getattr(new_data, name)
            _copy_run(source, target, old_model.jnt_dofadr[old], new_model.jnt_dofadr[new], dofs)


def _copy_run(source: np.ndarray, target: np.ndarray, start: Any, new_start: Any, count: Any) -> None:
    target[int(new_start) : int(new_start) + int(count)] = source[int(start) : int(start) + int(count)]


def _twins(old_model: Any, new_model: Any, kind: Any, copies: str | None) -> Iterator[tuple[str, int, int]]:
    """(name, old id, new id) of every named element both models have; with a prefix, copies and their originals too."""
    count = {
        mujoco.mjtObj.mjOBJ_BODY: new_model.nbody,
        mujoco.mjtObj.mjOBJ_GEOM: new_model.ngeom,
        mujoco.mjtObj.mjOBJ_SITE: new_model.nsite,
        mujoco.mjtObj.mjOBJ_CAMERA: new_model.ncam,
        mujoco.mjtObj.mjOBJ_LIGHT: new_model.nlight,
        mujoco.mjtObj.mjOBJ_JOINT: new_model.njnt,
        mujoco.mjtObj.mjOBJ_TENDON: new_model.ntendon,
        mujoco.mjtObj.mjOBJ_ACTUATOR: new_model.nu,
        mujoco.mjtObj.mjOBJ_EQUALITY: new_model.neq,
    }[kind]
    for new in range(count):
        name = mujoco.mj_id2name(new_model, kind, new)
        old = mujoco.mj_name2id(old_model, kind, name) if name else -1
        if old < 0 and name and copies is not None and name.startswith(copies):
            old = mujoco.mj_name2id(old_model, kind, name.removeprefix(copies))
        if old >= 0:
            yield name, old, new
