"""The colours of highlights: MuJoCo's materials have a strength, V-REP's a colour.

Where the colour is not grey, `<numeric name="simx:specular:MATERIAL" data="RED GREEN BLUE"/>` has it, each 0 to 1; the
material's `specular` is their mean.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.annotations import PREFIX

SPECULAR = f"{PREFIX}specular:"


def add_highlight(spec: mujoco.MjSpec, material: str, color: Sequence[float]) -> None:
    """Give a material of a spec highlights of a colour, RGB 0..1."""
    spec.add_numeric(name=SPECULAR + material, data=list(color), size=3)


def highlights_of(model: mujoco.MjModel) -> dict[int, NDArray[np.float64]]:
    """Return the colours of highlights by the id of the material: live views of (3,), RGB 0..1."""
    found: dict[int, NDArray[np.float64]] = {}
    for index in range(model.nnumeric):
        name = model.numeric(index).name
        if not name.startswith(SPECULAR):
            continue
        material = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_MATERIAL, name.removeprefix(SPECULAR))
        color = _color(model, index)
        if material >= 0 and color is not None:
            found[material] = color
    return found


def highlight_of(model: mujoco.MjModel, material: int) -> NDArray[np.float64] | None:
    """Return the same of one material; None if it is grey."""
    name = SPECULAR + model.mat(material).name
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_NUMERIC, name)
    return _color(model, index) if index >= 0 else None


def _color(model: mujoco.MjModel, index: int) -> NDArray[np.float64] | None:
    start = int(model.numeric_adr[index])
    return model.numeric_data[start : start + 3] if model.numeric_size[index] == 3 else None
