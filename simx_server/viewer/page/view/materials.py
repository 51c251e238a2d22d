"""The look of a geom in the browser: colour, gloss and texture, from MuJoCo's material."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
import trimesh.visual
import trimesh.visual.material
from numpy.typing import NDArray
from PIL import Image

from .tones import albedo, linear, paper

_DEFAULT_RGBA = (0.5, 0.5, 0.5, 1.0)
_GLOSS = (0.5, 0.5)
"""MuJoCo's specular and shininess of a geom without a material."""

_SHININESS = 128.0
"""Exponent of a highlight for MuJoCo's shininess 1."""

_LEAST_ROUGH = 0.3
"""A smoother surface would mirror the lights as points, and nothing else."""

_LARGEST = 1024
"""Pixels of a texture's longer side in the browser; larger ones are made smaller."""

_FLAT = int(mujoco.mjtTexture.mjTEXTURE_2D.value)
_SKY = int(mujoco.mjtTexture.mjTEXTURE_SKYBOX.value)
_ROLES = (int(mujoco.mjtTextureRole.mjTEXROLE_RGB.value), int(mujoco.mjtTextureRole.mjTEXROLE_RGBA.value))
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH.value)


@dataclass(frozen=True)
class Look:
    """Geoms with equal looks are drawn as one mesh. Colours as MuJoCo's."""

    rgba: tuple[float, float, float, float]
    roughness: float
    emission: float = 0.0
    texture: Texture | None = None


@dataclass(frozen=True, eq=False)
class Texture:
    """An image on one geom, with the colours of a browser's materials."""

    image: Image.Image


def look_of(model: mujoco.MjModel, geom: int) -> Look:
    """Return the look of a geom.

    Images are shown on planes, boxes and the like, and on meshes that have places in them. Of a cube's six images and
    of others that cannot be shown, the mean colour counts.
    """
    material = int(model.geom_matid[geom])
    if material < 0:
        return Look(_rounded(model.geom_rgba[geom]), _roughness(*_GLOSS))
    rgba = np.array(model.geom_rgba[geom] if has_own_color(model, geom) else model.mat_rgba[material], float)
    roughness = _roughness(model.mat_specular[material], model.mat_shininess[material])
    emission = round(float(model.mat_emission[material]), 3)
    texture: Texture | None = None
    number = next((n for role in _ROLES if (n := int(model.mat_texid[material, role])) >= 0), -1)
    if number >= 0 and int(model.tex_type[number]) != _SKY:
        pixels = pixels_of(model, number)
        is_placed = int(model.geom_type[geom]) != _MESH or model.mesh_texcoordnum[model.geom_dataid[geom]] > 0
        if int(model.tex_type[number]) == _FLAT and is_placed:
            texture = Texture(_image(pixels.tobytes(), pixels.shape))
        else:
            rgba[:3] *= _mean(pixels)
    return Look(_rounded(rgba), roughness, emission, texture)


def has_own_color(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a geom has its own colour: MuJoCo uses the material's while the own one is the default."""
    return int(model.geom_matid[geom]) < 0 or not np.allclose(model.geom_rgba[geom], _DEFAULT_RGBA)


def pixels_of(model: mujoco.MjModel, texture: int) -> NDArray[np.uint8]:
    """Return the pixels of a texture (height, width, 3), MuJoCo's lowest row first."""
    height, width, parts = (
        int(each[texture]) for each in (model.tex_height, model.tex_width, model.tex_nchannel)
    )
    first = int(model.tex_adr[texture])
    pixels = model.tex_data[first : first + height * width * parts].reshape(height, width, parts)
    return np.repeat(pixels[:, :, :1], 3, axis=2) if parts < 3 else pixels[:, :, :3]


def textured(look: Look, uv: NDArray[np.float64] | None) -> trimesh.visual.TextureVisuals:
    """Return what trimesh needs for a look; `uv` (N, 2): places of the points in the texture."""
    material: Any = trimesh.visual.material.PBRMaterial(  # trimesh declares little of it
        baseColorFactor=_factor(look),
        metallicFactor=0.0,
        roughnessFactor=look.roughness,
        alphaMode="BLEND" if look.rgba[3] < 1 else "OPAQUE",
    )
    if look.emission > 0:
        material.emissiveFactor = np.clip(look.emission * albedo(np.array(look.rgba[:3])), 0, 1)
    if look.texture is not None:
        material.baseColorTexture = look.texture.image
    return trimesh.visual.TextureVisuals(uv=uv if look.texture is not None else None, material=material)


def _factor(look: Look) -> list[float]:
    """Return the linear colour of a look; with a texture, the one by which it is multiplied."""
    rgb = np.array(look.rgba[:3])
    return [*(albedo(rgb) if look.texture is None else linear(np.clip(rgb, 0, 1))), look.rgba[3]]


def _roughness(specular: float, shininess: float) -> float:
    """Return the roughness of a surface whose highlight is as wide as MuJoCo's."""
    if specular <= 0:
        return 1.0
    return round(max(_LEAST_ROUGH, (2 / (_SHININESS * float(shininess) + 2)) ** 0.25), 2)


def _rounded(rgba: NDArray[Any]) -> tuple[float, float, float, float]:
    red, green, blue, alpha = (round(min(max(float(part), 0.0), 1.0), 4) for part in rgba)
    return red, green, blue, alpha


def _mean(pixels: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the mean colour, 0..1, of the pixels that are not black: MuJoCo leaves missing sides of a cube black."""
    painted = pixels[pixels.any(axis=2)]
    return painted.mean(axis=0) / 255 if len(painted) else np.zeros(3)


@lru_cache(maxsize=8)
def _image(pixels: bytes, shape: tuple[int, ...]) -> Image.Image:
    """Return a texture as an image for the browser, its highest row first; many geoms may have the same."""
    image = Image.fromarray(np.frombuffer(pixels, np.uint8).reshape(shape)[::-1].copy())
    image.thumbnail((_LARGEST, _LARGEST))
    return paper(image)
