"""The textures of the scene, by the numbers under which scripts know them.

Pixels that a script writes are shown once per simulation step, or when an image is taken in between, since each change
of a texture compiles the scene.
"""

from __future__ import annotations

import logging
from itertools import count
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scene.editing.recompile import edit
from simx_server.scene.naming.names import GRAFT_END, INTERNAL
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

logger = logging.getLogger(__name__)

Pixels = NDArray[np.uint8]

_STEM = INTERNAL + "texture"
_TEXTURE = mujoco.mjtObj.mjOBJ_TEXTURE
_COLORS = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
_FLAT = int(mujoco.mjtTexture.mjTEXTURE_2D)


class Textures(Part):
    """All flat textures. The stop undoes a run's changes; numbers stay until another scene is loaded."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._names: list[str] = []
        """Name of each texture that has a number, from 0."""
        self._written: dict[str, Pixels] = {}
        """Textures by name that the model has not got yet."""
        self.has_work = False
        """Whether scripts ever wrote a texture."""

    def scene_changed(self) -> None:
        self._names = []
        self._written = {}

    def run_starting(self) -> None:
        self.show()

    def run_stopped(self) -> None:
        self._written = {}

    def number_of(self, name: str) -> int:
        """Return the number of a texture by its full name."""
        if name not in self._names:
            self._names.append(name)
        return self._names.index(name)

    def find(self, name: str) -> int:
        """Return the number of a texture by its name, without the prefix of a loaded model; -1 if there is none."""
        model = self._sim.model
        names = [model.tex(each).name for each in range(model.ntex) if model.tex_type[each] == _FLAT]
        found = [full for full in names if full == name] or [
            full for full in names if full.rpartition(GRAFT_END)[2] == name
        ]
        return self.number_of(found[0]) if found else -1

    def name(self, number: int) -> str:
        """Return the full name of a texture. Raises CommandError: no such texture."""
        if not 0 <= number < len(self._names) or self._id(self._names[number]) < 0:
            present = [each for each, name in enumerate(self._names) if self._id(name) >= 0]
            known = ", ".join(map(str, present)) or "none so far"
            raise CommandError(
                f"no texture has the number {number}; numbers come from sim.getTextureId and the like: {known}"
            )
        return self._names[number]

    def of_geom(self, geom: int) -> int:
        """Return the number of the texture of a geom, -1 if it has none."""
        model = self._sim.model
        material = int(model.geom_matid[geom])
        texture = int(model.mat_texid[material, _COLORS]) if material >= 0 else -1
        if texture < 0 or model.tex_type[texture] != _FLAT:
            return -1
        return self.number_of(model.tex(texture).name)

    def pixels(self, number: int) -> Pixels:
        """Return a copy of the pixels (height, width, 3), the first row at v = 0. Raises CommandError."""
        name = self.name(number)
        if name in self._written:
            return self._written[name].copy()
        model, texture = self._sim.model, self._id(name)
        shape = (
            int(model.tex_height[texture]),
            int(model.tex_width[texture]),
            int(model.tex_nchannel[texture]),
        )
        start = int(model.tex_adr[texture])
        found = model.tex_data[start : start + shape[0] * shape[1] * shape[2]].reshape(shape)
        return np.repeat(found, 3, axis=2) if shape[2] == 1 else found[..., :3].copy()

    def write(self, number: int, pixels: Pixels) -> None:
        """Replace all pixels (height, width, 3). Raises CommandError."""
        self._written[self.name(number)] = pixels
        if not self.has_work:
            self.has_work = True
            self._sim.parts.replan()

    def add(self, pixels: Pixels) -> str:
        """Add a texture (height, width, 3) that nothing has yet, and return its full name. Raises CommandError."""
        taken = {texture.name for texture in self._sim.scene.spec.textures}
        name = next(name for number in count() if (name := f"{_STEM}{number}") not in taken)
        edit(self._sim, lambda spec: paint(spec.add_texture(name=name), pixels), set())
        return name

    def show(self) -> None:
        """Bring the model up to date. It takes long only when pixels were written."""
        if not self._written or self._sim.physics_calls.name:
            return
        written = {name: pixels for name, pixels in self._written.items() if self._id(name) >= 0}
        self._written = {}

        def surgery(spec: mujoco.MjSpec) -> None:
            for name, pixels in written.items():
                paint(spec.texture(name), pixels)

        try:
            edit(self._sim, surgery, set())
        except CommandError as problem:
            logger.error("textures that a script wrote are not shown: %s", problem)

    def _id(self, name: str) -> int:
        return mujoco.mj_name2id(self._sim.model, _TEXTURE, name)


def paint(texture: Any, pixels: Pixels) -> None:
    """Give a texture of a spec these pixels (height, width, 3)."""
    texture.type = mujoco.mjtTexture.mjTEXTURE_2D
    texture.file, texture.builtin = "", int(mujoco.mjtBuiltin.mjBUILTIN_NONE)
    texture.height, texture.width = pixels.shape[:2]
    texture.nchannel = 3
    texture.data = np.ascontiguousarray(pixels).tobytes()
