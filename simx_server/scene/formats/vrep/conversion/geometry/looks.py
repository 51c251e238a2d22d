"""Colours and textures of leaves as materials and textures of a spec."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.conversion.unique_names import UniqueNames
from simx_server.scene.formats.vrep.objects import Color, Leaf, Material, VisionSensor
from simx_server.scene.geometry.highlights import add_highlight

from .damage import within
from .texture_mapping import DECAL, INTERPOLATED

_SHINIEST = 128
"""Greatest shininess in OpenGL's numbers."""

_GREY = 0.01
"""Most difference of the parts of a colour that counts as grey."""

_LARGEST = 4096
"""Largest side of a texture in pixels."""

_SENSOR_IMAGE = "the texture that is the image of a vision sensor is left out"
_NO_TEXTURE = "a texture that is not in the file is left out"
_NO_PIXELS = "a texture without pixels is left out"
_SMOOTHED = "a texture is drawn with smoothed pixels"


@dataclass
class Looks:
    """The materials and textures that a conversion has added to its spec."""

    conversion: Conversion
    materials: dict[tuple[object, ...], str] = field(default_factory=dict[tuple[object, ...], str])
    textures: dict[int, str | None] = field(default_factory=dict[int, "str | None"])
    names: UniqueNames = field(default_factory=lambda: UniqueNames("{}_{}", first=1))

    @classmethod
    def of(cls, conversion: Conversion) -> Looks:
        """Return the looks of a conversion."""
        return conversion.part(cls, lambda: cls(conversion))

    def has_texture(self, leaf: Leaf, owner: str) -> bool:
        """Return whether the scene gets a leaf's texture; the report names the ones that it does not get."""
        return leaf.texture is not None and self._texture(leaf.texture.texture, owner) is not None

    def material_of(self, leaf: Leaf, *, texture: bool) -> str:
        """Return the material of a leaf.

        Args:
            texture: whether the leaf shows its texture.
        """
        use = leaf.texture if texture else None
        is_decal = use is not None and bool(use.flags & DECAL)
        rgb, emission = _glow(leaf.material)
        if is_decal:  # light does not change it
            rgb, emission = (1.0, 1.0, 1.0), 1.0
        highlight = (0.0,) * 3 if is_decal else tuple(within(value, 0.0) for value in leaf.material.specular)
        specular = sum(highlight) / 3
        image = None if use is None else self.textures[use.texture]
        alpha = within(leaf.material.opacity, 1.0)
        shininess = min(max(leaf.material.shininess, 0), _SHINIEST) / _SHINIEST if specular else 0.0
        numbers = (round(value, 4) for value in (*rgb, alpha, emission, *highlight, shininess))
        key = (leaf.material.name, *numbers, image)  # scripts find colours by their names
        if key not in self.materials:
            sheen = specular, shininess
            self.materials[key] = self._add(leaf.material.name, rgb, alpha, emission, sheen, image)
            if max(highlight) - min(highlight) > _GREY:
                add_highlight(self.conversion.spec, self.materials[key], highlight)
        if use is not None and not use.flags & INTERPOLATED:
            self.conversion.report.approximate(_SMOOTHED)
        return self.materials[key]

    def painted(self, name: str, pixels: NDArray[np.uint8], emission: float) -> str:
        """Return a material that shows an image, RGB, and nothing else."""
        return self._add(name, (1.0, 1.0, 1.0), 1.0, emission, (0.0, 0.0), self._image(pixels))

    def _add(
        self,
        name: str,
        rgb: Color,
        alpha: float,
        emission: float,
        sheen: tuple[float, float],
        image: str | None,
    ) -> str:
        """Add a material and return its name. `sheen`: specular part and shininess, each 0..1."""
        wanted = "".join(letter if letter.isalnum() else "_" for letter in name) or "color"
        unique = self.names.take(wanted)
        material: Any = self.conversion.spec.add_material(name=unique)
        material.rgba = [*rgb, alpha]
        material.emission = emission
        material.specular, material.shininess = sheen
        if image is not None:
            material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = image
        return unique

    def _texture(self, number: int, owner: str) -> str | None:
        """Return the name of a texture of the file, or None where there is none to show."""
        file, report = self.conversion.file, self.conversion.report
        if number not in self.textures:
            texture = file.textures.get(number)
            self.textures[number] = None if texture is None else self._image(texture.pixels)
        if self.textures[number] is None:
            if isinstance(file.objects.get(number), VisionSensor):
                report.leave_out(_SENSOR_IMAGE, owner)
            else:
                report.leave_out(_NO_PIXELS if number in file.textures else _NO_TEXTURE, owner)
        return self.textures[number]

    def _image(self, pixels: NDArray[np.uint8]) -> str | None:
        """Add a texture, as a PNG among the spec's files: a spec with bare pixels cannot be written as MJCF."""
        if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or not pixels.size:
            return None
        height, width = pixels.shape[:2]
        if max(height, width) > _LARGEST:
            share = _LARGEST / max(height, width)
            size = max(1, round(width * share)), max(1, round(height * share))
            pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA).astype(np.uint8)
        name = f"texture{len(self.conversion.spec.textures) + 1}"
        added: Any = self.conversion.spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D)
        added.file = f"{name}.png"
        self.conversion.spec.assets[added.file] = _png(pixels)
        return name


def _glow(material: Material) -> tuple[Color, float]:
    """Return a colour, and the share of it that is there without light: MuJoCo's emission has the colour itself."""
    diffuse = tuple(map(within, material.diffuse))
    emission = tuple(within(value, 0.0) for value in material.emission)
    given, own = sum(emission), sum(diffuse)
    if given > own:  # a lamp: what it reflects hardly shows
        return (emission[0], emission[1], emission[2]), 1.0
    return (diffuse[0], diffuse[1], diffuse[2]), given / own if own else 0.0


def _png(pixels: NDArray[np.uint8]) -> bytes:
    """Return RGB pixels as a PNG; the first row of either lies at v = 0. Without transparency."""
    done, encoded = cv2.imencode(".png", np.ascontiguousarray(pixels[..., 2::-1]))
    if not done:
        raise ValueError(f"a texture of {pixels.shape} pixels cannot be written as PNG")
    return encoded.tobytes()
