"""Write into a spec what commands have written into the arrays of the model, so that it gives the same numbers."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.editing.twins import Names, Twins
from simx_server.scene.poses.poses import IDENTITY, Pose, Vector, compose, inverse, rotate

_PLAIN: Mapping[str, Mapping[str, str]] = {
    "geom": {
        f"geom_{name}": name
        for name in (
            *("rgba", "friction", "solref", "solimp", "solmix", "margin", "condim", "priority"),
            *("contype", "conaffinity", "group"),
        )
    },
    "site": {"site_rgba": "rgba"},
    "cam": {"cam_fovy": "fovy", "cam_resolution": "resolution"},
    "light": {
        f"light_{name}": name
        for name in (
            *("active", "diffuse", "ambient", "specular", "attenuation", "cutoff", "exponent"),
            "castshadow",
        )
    },
    "jnt": {"jnt_range": "range", "jnt_stiffness": "stiffness"},
    "tendon": {"tendon_range": "range"},
    "mat": {f"mat_{name}": name for name in ("rgba", "emission", "specular")},
}
"""Arrays by the kind of element, with the attributes that give their numbers."""

_LIMITED = {"jnt": "jnt_limited", "tendon": "tendon_limited"}

_GETTERS = {"jnt": "joint", "cam": "camera", "mat": "material"}
"""Kinds whose elements a spec returns under another name."""

_POSED = {"geom": ("pos", "quat"), "site": ("pos", "quat"), "cam": ("pos", "quat"), "light": ("pos", "dir")}

_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
_FIXED = mujoco.mjtCamLight.mjCAMLIGHT_FIXED
_QUATERNION = mujoco.mjtOrientation.mjORIENTATION_QUAT

Withheld = Mapping[tuple[str, str], int]
"""Numbers that models' properties replace in geoms: (geom name, array) to the geom's own."""


def settle(
    spec: mujoco.MjSpec,
    compiled: mujoco.MjModel,
    model: mujoco.MjModel,
    *,
    withheld: Withheld,
    weightless: Collection[str],
    moved: Collection[tuple[str, str]] = (),
) -> bool:
    """Write the numbers of a model into a spec.

    Args:
        spec: it has some or all elements of the model, by the same names.
        compiled: the model that the spec gives.
        model: the scene's model.
        withheld: what the geoms have in place of the model's numbers.
        weightless: names of bodies whose weight stays that of the spec.
        moved: (array prefix, element name) of elements whose pose stays that of the spec.

    Returns:
        Whether the spec has changed.
    """
    settling = _Settling(spec, compiled, model, moved)
    settling.set_plain(withheld)
    settling.set_limits()
    settling.set_damping()
    settling.set_poses()
    settling.set_bodies(weightless)
    settling.set_numerics()
    return settling.has_changed


class _Settling:
    def __init__(
        self,
        spec: mujoco.MjSpec,
        compiled: mujoco.MjModel,
        model: mujoco.MjModel,
        moved: Collection[tuple[str, str]],
    ) -> None:
        self.has_changed = False
        self._spec, self._compiled, self._model, self._moved = spec, compiled, model, set(moved)
        self._twins = Twins(Names(model), compiled)

    def _each(self, kind: str, own: Mapping[int, Any] | None, *arrays: str) -> list[tuple[Any, int, int]]:
        """Return the elements with different numbers in one of the arrays: element, id in the model, id compiled.

        Args:
            kind: of the elements.
            own: numbers by id in place of those of the model's (first) array.
            arrays: to compare.
        """
        here, there = self._twins.pairs(kind)
        if not len(here):
            return []
        differs = np.zeros(len(here), bool)
        for array in arrays:
            wanted, found = getattr(self._model, array)[here], getattr(self._compiled, array)[there]
            if own:
                wanted = wanted.copy()
                for place, index in enumerate(here.tolist()):
                    wanted[place] = own.get(index, wanted[place])
            differs |= (wanted != found).reshape(len(here), -1).any(axis=1)
        names = self._twins.new.of(kind)
        find: Callable[[str], Any] = getattr(self._spec, _GETTERS.get(kind, kind))
        rows: Iterable[tuple[int, int]] = zip(here[differs].tolist(), there[differs].tolist(), strict=True)
        chosen: list[tuple[Any, int, int]] = [(find(names[twin]), index, twin) for index, twin in rows]
        self.has_changed |= bool(chosen)
        return chosen

    def set_plain(self, withheld: Withheld) -> None:
        for kind, arrays in _PLAIN.items():
            for array, attribute in arrays.items():
                own = {
                    mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_GEOM, name): value
                    for (name, which), value in withheld.items()
                    if which == array
                }
                for element, index, _ in self._each(kind, own, array):
                    _write(element, attribute, own.get(index, getattr(self._model, array)[index]))

    def set_limits(self) -> None:
        limited = mujoco.mjtLimited
        for kind, array in _LIMITED.items():
            for element, index, _ in self._each(kind, None, array):
                is_limited = getattr(self._model, array)[index]
                element.limited = int(limited.mjLIMITED_TRUE if is_limited else limited.mjLIMITED_FALSE)
        for element, index, _ in self._each("jnt", None, "jnt_pos", "jnt_axis"):
            frame = inverse(_frame(element))
            element.pos[:] = compose(frame, (_vector(self._model.jnt_pos[index]), IDENTITY[1]))[0]
            element.axis[:] = rotate(frame[1], _vector(self._model.jnt_axis[index]))

    def set_damping(self) -> None:
        here, there = self._twins.pairs("jnt")
        wanted = self._model.dof_damping[self._model.jnt_dofadr[here]]
        differs = wanted != self._compiled.dof_damping[self._compiled.jnt_dofadr[there]]
        names = self._twins.new.of("jnt")
        for twin, value in zip(there[differs].tolist(), wanted[differs].tolist(), strict=True):
            self._spec.joint(names[twin]).damping[0] = value
            self.has_changed = True

    def set_poses(self) -> None:
        for kind, (_, turn) in _POSED.items():
            arrays = [f"{kind}_pos", f"{kind}_{turn}"]
            arrays += [f"{kind}_mode"] if kind in ("cam", "light") else [f"{kind}_size"]
            for element, index, twin in self._each(kind, None, *arrays):
                if (f"{kind}_", element.name) in self._moved:
                    continue
                if kind in ("cam", "light"):
                    element.mode = (
                        _FIXED if getattr(self._model, arrays[2])[index] == _FIXED.value else element.mode
                    )
                elif kind == "site" or self._model.geom_type[index] != _MESH:
                    element.size[:] = getattr(self._model, arrays[2])[index]
                    element.fromto[:] = np.nan
                if kind == "light":
                    self._set_light(element, index)
                elif kind == "geom" and self._model.geom_type[index] == _MESH:
                    self._set_mesh_pose(element, index, twin)
                else:
                    _set_pose(element, _pose(self._model, kind, index))

    def _set_light(self, element: Any, index: int) -> None:
        frame = inverse(_frame(element))
        element.pos[:] = compose(frame, (_vector(self._model.light_pos[index]), IDENTITY[1]))[0]
        element.dir[:] = rotate(frame[1], _vector(self._model.light_dir[index]))

    def _set_mesh_pose(self, element: Any, index: int, twin: int) -> None:
        """Set the pose of a mesh: MuJoCo moves its points, and the geom against them."""
        inner = compose(inverse(_frame_and(element)), _pose(self._compiled, "geom", twin))
        _set_pose(element, compose(_pose(self._model, "geom", index), inverse(inner)))

    def set_bodies(self, weightless: Collection[str]) -> None:
        model = self._model
        for element, index, _ in self._each("body", None, "body_pos", "body_quat"):
            if ("body_", element.name) not in self._moved:
                _set_pose(element, _pose(model, "body", index))
        inertia = ("body_mass", "body_inertia", "body_ipos", "body_iquat")
        for element, index, _ in self._each("body", None, *inertia):
            if element.name in weightless or element.name == "world":
                continue
            element.explicitinertial = True
            element.mass = float(model.body_mass[index])
            element.inertia[:] = model.body_inertia[index]
            element.ipos[:], element.iquat[:] = model.body_ipos[index], model.body_iquat[index]
            element.fullinertia[:] = np.nan
            element.ialt.type = _QUATERNION

    def set_numerics(self) -> None:
        here, there = self._twins.pairs("numeric")
        names = self._twins.new.of("numeric")
        for old, new in zip(here.tolist(), there.tolist(), strict=True):
            start, count = int(self._model.numeric_adr[old]), int(self._model.numeric_size[old])
            self._spec.numeric(names[new]).data = self._model.numeric_data[start : start + count].tolist()


def _write(element: Any, attribute: str, value: Any) -> None:
    if isinstance(getattr(element, attribute), np.ndarray):
        getattr(element, attribute)[:] = value
    else:
        setattr(element, attribute, value.item() if hasattr(value, "item") else value)


def _vector(values: NDArray[Any]) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def _pose(model: mujoco.MjModel, kind: str, index: int) -> Pose:
    w, x, y, z = getattr(model, f"{kind}_quat")[index].tolist()
    return _vector(getattr(model, f"{kind}_pos")[index]), (w, x, y, z)


def _own_pose(element: Any) -> Pose:
    w, x, y, z = element.quat.tolist()
    return _vector(element.pos), (w, x, y, z)


def _frame(element: Any) -> Pose:
    """Return the pose of the frames in which an element lies, in its body."""
    pose, frame = IDENTITY, element.frame
    while frame is not None:
        pose, frame = compose(_own_pose(frame), pose), frame.frame
    return pose


def _frame_and(element: Any) -> Pose:
    return compose(_frame(element), _own_pose(element))


def _set_pose(element: Any, pose: Pose) -> None:
    """Set the pose of an element in its body."""
    if element.frame is not None:
        pose = compose(inverse(_frame(element)), pose)
    element.pos[:], element.quat[:] = pose
    element.alt.type = _QUATERNION
