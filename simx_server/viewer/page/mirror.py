"""A copy of the server's model and state in the viewer's process, from the feed's answers."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from simx_server.scene.editing.model_state import STATE, editable_arrays
from simx_server.sensors.vision.content import Content, content_of
from simx_server.viewer.messages import Look

_SHAPES = ("geom_", "mat_", "site_size")
"""Prefixes of arrays that change what a body looks like, not only its pose."""


@dataclass(eq=False)
class Copy:
    """A model with its state; forward kinematics done."""

    model: mujoco.MjModel
    data: mujoco.MjData

    @cached_property
    def content(self) -> Content | None:
        """Return what there is to see beside the ground, where it was at first; None: nothing."""
        return content_of(self.model, self.data)

    @property
    def extent(self) -> float:
        """Return the size of the content in metres, to which marks are drawn."""
        return float(self.model.stat.extent) if self.content is None else 2 * self.content.radius


class Mirror:
    """Follows the server. `update` for each look; one thread."""

    def __init__(self) -> None:
        self.copy: Copy | None = None
        self.is_past = False
        """The copy is that of a past step, and the panels show the present."""

        self._first: dict[str, np.ndarray] = {}
        """The arrays as they were in the model file."""

    def update(self, look: Look) -> tuple[bool, bool]:
        """Copy the state from a look. Returns (another model, bodies look different)."""
        binary, arrays = look["binary"], look["arrays"]
        if binary is not None:
            model = mujoco.MjModel.from_binary_path("scene.mjb", {"scene.mjb": zlib.decompress(binary)})
            # Sleeping bodies would keep forces of other times.
            model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)
            self.copy = Copy(model, mujoco.MjData(model))
            self._first = {name: value.copy() for name, value in editable_arrays(model)}
        copy = self.copy
        if copy is None:
            raise ValueError("the first look must bring a model")
        is_reshaped = arrays is not None and self._write(copy.model, arrays)
        state = np.frombuffer(look["state"])
        mujoco.mj_setState(copy.model, copy.data, state, STATE)
        mujoco.mj_kinematics(copy.model, copy.data)
        mujoco.mj_camlight(copy.model, copy.data)
        return binary is not None, is_reshaped

    def _write(self, model: mujoco.MjModel, arrays: dict[str, bytes]) -> bool:
        is_reshaped = False
        for name, value in editable_arrays(model):
            written = arrays.get(name)
            now = self._first[name] if written is None else np.frombuffer(written, value.dtype)
            if value.tobytes() != now.tobytes():
                value[...] = now.reshape(value.shape)
                is_reshaped |= name.startswith(_SHAPES)
        return is_reshaped
