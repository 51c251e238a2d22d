"""Contexts of MuJoCo, which hold a model's meshes and textures in OpenGL.

Making a context of MuJoCo holds the interpreter lock, so other threads stand still, and a driver that compiles a
shader for the first texture of its kind takes a third of a second. So contexts are made with textures of one pixel,
and the real ones follow by `mjr_uploadTexture`, which lets other threads run. A new model is drawn in the same
OpenGL context, in which the shader is compiled already. If it has the meshes and textures of the model before, as after
most edits of a scene, MuJoCo's context is kept too.
"""

import copy
from functools import cache

import mujoco
import numpy as np

OFFSCREEN = int(mujoco.mjtFramebuffer.mjFB_OFFSCREEN)


def drawing_of(model: mujoco.MjModel, *, is_coarse: bool = False) -> mujoco.MjrContext:
    """Return a context that draws a model: its meshes, its textures and an offscreen buffer.

    Args:
        model: the model.
        is_coarse: round geoms have half the corners.
    """
    # A copy: sizes are read from the model, which must not change.
    plain = copy.copy(model)
    quality = plain.vis.quality
    quality.offsamples = quality.shadowsize = 0
    plain.vis.global_.offwidth = plain.vis.global_.offheight = 1
    plain.tex_width[:] = plain.tex_height[:] = 1
    if is_coarse:
        quality.numslices //= 2
        quality.numstacks //= 2
    drawing = mujoco.MjrContext(plain, mujoco.mjtFontScale.mjFONTSCALE_50.value)
    for texture in textures_of(model):
        mujoco.mjr_uploadTexture(model, drawing, texture)
    mujoco.mjr_setBuffer(OFFSCREEN, drawing)
    # The buffer holds 1 at the near plane and 0 at the far plane: return it unchanged.
    drawing.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
    return drawing


def textures_of(model: mujoco.MjModel) -> set[int]:
    """Return the ids of the textures that materials have; the skybox has none."""
    return set(model.mat_texid.ravel().tolist()) - {-1}


def have_one_drawing(one: mujoco.MjModel, other: mujoco.MjModel) -> bool:
    """Return whether the context of one model also draws another, if it gets the textures that only the other uses."""
    return all(
        (first := getattr(one, name)).shape == (second := getattr(other, name)).shape
        and np.array_equal(first, second)
        for name in _drawn_arrays()
    ) and all(
        getattr(one.vis.quality, name) == getattr(other.vis.quality, name)
        for name in ("numslices", "numstacks", "numquads")
    )


_DRAWN = ("mesh_", "hfield_", "skin_", "tex_")
_NOT_DRAWN = ("mesh_bvh", "mesh_oct", "mesh_poly", "mesh_pos", "mesh_quat", "mesh_scale")
"""Prefixes of the names of arrays that a context is made of, and of those among them that it is not."""


@cache
def _drawn_arrays() -> tuple[str, ...]:
    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    names = (
        name
        for name in dir(model)
        if name.startswith(_DRAWN) and not name.startswith(_NOT_DRAWN) and not name.endswith("pathadr")
    )
    # The small ones first: they mostly show a difference.
    found = [name for name in names if isinstance(getattr(model, name), np.ndarray)]
    return tuple(sorted(found, key=lambda name: not name.endswith(("adr", "num"))))
