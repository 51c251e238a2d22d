"""The geoms of a MuJoCo scene as arrays. A loop in Python over them takes longer than drawing many of them.

MuJoCo's bindings have an object for each geom. Its arrays lie in the memory of the scene, so their addresses give
those of all geoms. The place of a number in a geom is found by writing it.
"""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

_MARK = 0x13579BDF
"""A number that no geom contains."""

_FIRST = "type"
"""The first member of a geom."""


class DrawnGeoms:
    """Columns of all places for geoms in a scene; places from `scene.ngeom` on are free."""

    def __init__(self, scene: mujoco.MjvScene) -> None:
        """Make the columns.

        Args:
            scene: has room for at least two geoms.
        """
        self._scene = scene  # which owns the memory
        layout = _layout()
        first = _address(scene.geoms[0]) + layout.offsets[_FIRST]
        self.rows = _memory(first, scene.maxgeom * layout.size).reshape(scene.maxgeom, layout.size)
        """(maxgeom, bytes): whole geoms, to copy."""

        self.type = self._column("type", np.int32)
        self.dataid = self._column("dataid", np.int32)
        self.objtype = self._column("objtype", np.int32)
        self.objid = self._column("objid", np.int32)
        self.segid = self._column("segid", np.int32)
        self.reflectance = self._column("reflectance", np.float32)
        self.pos = self._column("pos", np.float32, 3)
        self.mat = self._column("mat", np.float32, 9).reshape(-1, 3, 3)
        self.rgba = self._column("rgba", np.float32, 4)

    def _column(self, name: str, kind: Any, count: int = 1) -> NDArray[Any]:
        layout = _layout()
        start = layout.offsets[name] - layout.offsets[_FIRST]
        column = self.rows[:, start : start + count * np.dtype(kind).itemsize].view(kind)
        return column if count > 1 else column[:, 0]


class _Layout(NamedTuple):
    size: int
    """Bytes from one geom to the next."""
    offsets: dict[str, int]
    """Bytes from a geom's array `size` to its other members."""


@cache
def _layout() -> _Layout:
    scene = mujoco.MjvScene(mujoco.MjModel.from_xml_string("<mujoco/>"), 3)
    before, geom, after = (_address(each) for each in scene.geoms)
    offsets: dict[str, int] = {}
    for name in (_FIRST, "dataid", "objtype", "objid", "segid", "reflectance"):
        mark = np.array(_MARK, np.int32)
        setattr(scene.geoms[1], name, mark.view(np.float32) if name == "reflectance" else mark)
        (found,) = np.flatnonzero(_memory(before, after - before).view(np.int32) == mark)
        offsets[name] = 4 * int(found) + before - geom
        setattr(scene.geoms[1], name, 0)
    for name in ("pos", "mat", "rgba"):
        offsets[name] = _address(scene.geoms[1], name) - geom
    return _Layout(geom - before, offsets)


def _address(geom: Any, name: str = "size") -> int:
    return getattr(geom, name).__array_interface__["data"][0]


def _memory(address: int, size: int) -> NDArray[np.uint8]:
    return np.ctypeslib.as_array((ctypes.c_uint8 * size).from_address(address))
