"""Textures: find, read and write them, and apply them to shapes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from simx_server.editing import shape_looks
from simx_server.editing.textured_planes import create_textured_plane, plane_triangles
from simx_server.errors import CommandError
from simx_server.files.image_files import fitted
from simx_server.handlers.scene_files.script_files import read_image
from simx_server.parts.textures.dressing import Dress, dress, undress
from simx_server.parts.textures.textures import Pixels
from simx_server.scene.geometry.triangles import corners_of
from simx_server.scene.poses import frames
from simx_server.scene.poses.poses import Pose
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads

if TYPE_CHECKING:
    from simx_server.scene.formats.vrep.conversion.geometry.texture_mapping import Coordinates

_DECAL = 2
_RGBA, _MIRRORED, _UPSIDE_DOWN = 16, 32, 64
"""Bits of the options of sim.applyTexture."""
_ELLIPSE = 4
"""Bit of the options of sim.writeTexture."""

_USUAL_RESOLUTION = [128, 128]
_LARGEST = 4096
"""Largest side of a texture in pixels."""
_LARGEST_PLANE = 1e4
"""Metres."""


class TextureFunctions(ApiPart, effect="changes"):
    """Functions for textures: a texture's first row of pixels is at the bottom. A stop undoes the changes of a run."""

    @reads
    def getTextureId(self, name: str) -> tuple[int, list[int]] | int:
        """Return the number of a texture and {width, height}; -1 if there is none of this name."""
        number = self._world.textures.find(name)
        if number < 0:
            return -1
        height, width = self._world.textures.pixels(number).shape[:2]
        return number, [width, height]

    @reads
    def getShapeTextureId(self, shape: int) -> int:
        """Return the number of the texture of a shape, of its first part with one; -1 if there is none."""
        parts = self._world.shape_colors.parts(self._self(shape))
        return next(
            (number for each in parts if (number := self._world.textures.of_geom(each.geom)) >= 0), -1
        )

    @reads
    def readTexture(
        self, texture: int, _options: int = 0, x: int = 0, y: int = 0, width: int = 0, height: int = 0
    ) -> bytes:
        """Return red, green, blue of each pixel in a part of a texture, or in all of it with sizes 0."""
        pixels = self._world.textures.pixels(texture)
        rows, columns = _region(pixels, x, y, width, height)
        return pixels[rows, columns].tobytes()

    def writeTexture(
        self,
        texture: int,
        options: int,
        data: bytes,
        x: int = 0,
        y: int = 0,
        width: int = 0,
        height: int = 0,
        interpolation: float = 0.0,
    ) -> int:
        """Replace pixels in a part of a texture, or in all of it with sizes 0; option 4: only within an ellipse. Images
        show them from the next simulation step on. `interpolation`: share of the present pixels that stays, 0 to 1.
        """
        if not 0 <= interpolation <= 1:
            raise CommandError(f"an interpolation is from 0 to 1, not {interpolation:g}")
        pixels = self._world.textures.pixels(texture)
        rows, columns = _region(pixels, x, y, width, height)
        shape = pixels[rows, columns].shape
        if len(data) < math.prod(shape):
            raise CommandError(
                f"{shape[1]} x {shape[0]} pixels have {math.prod(shape)} bytes, not {len(data)}"
            )
        given = np.frombuffer(data[: math.prod(shape)], np.uint8).reshape(shape)
        if interpolation:
            mixed = given * (1.0 - interpolation) + pixels[rows, columns] * interpolation
            given = mixed.astype(np.uint8)
        if options & _ELLIPSE:
            up, across = (np.linspace(-1, 1, 2 * size + 1)[1::2] for size in shape[:2])
            inside = up[:, np.newaxis] ** 2 + across**2 <= 1.0
            given = np.where(inside[..., np.newaxis], given, pixels[rows, columns])
        pixels[rows, columns] = given
        self._world.textures.write(texture, pixels)
        return 1

    def createTexture(
        self,
        file: str,
        options: int,
        sizes: list[float] | None = None,
        scaling: list[float] | None = None,
        shift: list[float] | None = None,
        largest: int = 0,
        resolution: list[int] | None = None,
    ) -> tuple[int, int, list[int]]:
        """Create a plane that shows an image file of the workspace, or a new white texture with an empty name; return
        its handle, the number of the texture, and {width, height}. `options`: 2 light does not change it; `sizes`: of
        the plane (m); `scaling`: metres of a repetition along u and v; `shift`: x, y (m) and angle (rad) of the
        texture; `largest`: the image gets sides of powers of two up to it; `resolution`: of a new texture.

        Partly: pixels are interpolated (option 1 asks for none), and a texture is always repeated (options 4, 8).
        """
        pixels = (
            fitted(read_image(self._world, file), largest)
            if file
            else _blank(resolution or _USUAL_RESOLUTION)
        )
        height, width = pixels.shape[:2]
        plane = _numbers(sizes, 2) if sizes else [1.0, height / width]
        if not all(0 < size <= _LARGEST_PLANE for size in plane):
            raise CommandError(f"a plane has sizes above 0, up to {_LARGEST_PLANE:g} m, not {plane}")
        x, y, angle = _numbers(shift, 3) if shift else [0.0] * 3
        frame = _pose([x, y, 0.0], [0.0, 0.0, angle])
        across, up = _numbers(scaling, 2) if scaling else plane
        triangles = plane_triangles(plane[0], plane[1])
        coordinates = _projected(triangles, (across, up), frame)
        name = Path(file).stem or "texture"
        handle = create_textured_plane(
            self._world, name, pixels, triangles, coordinates, is_decal=bool(options & _DECAL)
        )
        return handle, self.getShapeTextureId(handle), [width, height]

    def setShapeTexture(
        self,
        shape: int,
        texture: int,
        mapping: int,
        options: int,
        scaling: list[float],
        position: list[float] | None = None,
        orientation: list[float] | None = None,
    ) -> int:
        """Apply a texture to all parts of a shape, or none with -1. `mapping`: sim.texturemap_*; `options`: 2 light
        does not change it; `scaling`: metres of a repetition along u and v; position and Euler angles of its frame in
        the shape.

        Partly: a primitive counts as a mesh then; pixels are interpolated (option 1 asks for none), and the texture is
        always repeated (options 4, 8).
        """
        handle = self._self(shape)
        geoms = [each.geom for each in self._world.shape_colors.parts(handle)]
        if texture == -1:
            undress(self._sim, geoms)
            return 1
        if not 0 <= mapping <= 3:
            raise CommandError(f"{mapping} is no mapping; those are 0 plane, 1 cylinder, 2 sphere, 3 cube")
        across, up = _numbers(scaling, 2)
        frame = _pose(position or [0.0] * 3, orientation or [0.0] * 3)
        name = self._world.textures.name(texture)
        wanted: dict[int, Dress] = {}
        for geom in geoms:
            local = shape_looks.part_corners(self._world, handle, geom)
            if len(local):
                wanted[geom] = Dress(
                    self._in_body(geom),
                    _projected(local, (across, up), frame, mapping),
                    name,
                    bool(options & _DECAL),
                )
        dress(self._sim, wanted)
        return 1

    def applyTexture(
        self, shape: int, coordinates: list[float], texture: bytes, resolution: list[int], options: int = 0
    ) -> int:
        """Apply a new texture to a shape of one part by the u and v of each corner of its triangles, in the order of
        sim.getShapeViz; return its number. `options`: 2 light does not change it, 16 pixels are RGBA, 32 mirrored, 64
        upside down.

        Partly: as sim.setShapeTexture; the fourth component of pixels is ignored.
        """
        handle = self._self(shape)
        parts = self._world.shape_colors.parts(handle)
        if len(parts) != 1:
            raise CommandError(
                f"the shape has {len(parts)} parts; coordinates are those of a shape of one part"
            )
        geom = parts[0].geom
        local = shape_looks.part_corners(self._world, handle, geom)
        if len(coordinates) != 6 * len(local):
            raise CommandError(
                f"{len(local)} triangles have {6 * len(local)} numbers u and v of their corners; got {len(coordinates)}"
            )
        width, height = _sides(resolution)
        channels = 4 if options & _RGBA else 3
        if len(texture) < width * height * channels:
            raise CommandError(
                f"{width} x {height} pixels have {width * height * channels} bytes, not {len(texture)}"
            )
        pixels = np.frombuffer(texture[: width * height * channels], np.uint8).reshape(
            height, width, channels
        )
        pixels = pixels[:: -1 if options & _UPSIDE_DOWN else 1, :: -1 if options & _MIRRORED else 1, :3]
        name = self._world.textures.add(np.ascontiguousarray(pixels))
        uv = np.array(coordinates, np.float32).reshape(-1, 3, 2)
        dress(self._sim, {geom: Dress(self._in_body(geom), uv, name, bool(options & _DECAL))})
        return self._world.textures.number_of(name)

    def _in_body(self, geom: int) -> NDArray[np.float64]:
        """Return the triangles (m, 3, 3) of a geom in the frame of its body."""
        model = self._sim.model
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        return corners_of(model, geom) @ turn.reshape(3, 3).T + model.geom_pos[geom]


def _projected(
    corners: NDArray[np.float64], scale: tuple[float, float], frame: Pose, mapping: int = 0
) -> Coordinates:
    """Return u and v (m, 3, 2) of the corners of triangles (m, 3, 3)."""
    # slow, and often not needed
    from simx_server.scene.formats.vrep.conversion.geometry.texture_mapping import coordinates_of
    from simx_server.scene.formats.vrep.objects import Leaf, TextureUse

    use = TextureUse(texture=0, mode=mapping, scale=scale, frame=frame)
    points = corners.reshape(-1, 3).astype(np.float32)
    faces = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    return coordinates_of(Leaf(vertices=points, triangles=faces), use)


def _region(pixels: Pixels, x: int, y: int, width: int, height: int) -> tuple[slice, slice]:
    """Return the rows and columns of a part of a texture. Raises CommandError."""
    rows, columns = pixels.shape[:2]
    width, height = width or columns - x, height or rows - y
    if not (0 <= x < columns and 0 <= y < rows and 0 < width <= columns - x and 0 < height <= rows - y):
        raise CommandError(f"{width} x {height} pixels from ({x}, {y}) are not within {columns} x {rows}")
    return slice(y, y + height), slice(x, x + width)


def _pose(position: list[float], orientation: list[float]) -> Pose:
    x, y, z = _numbers(position, 3)
    return (x, y, z), frames.quat_from_euler(_numbers(orientation, 3))


def _numbers(given: list[float], count: int) -> list[float]:
    if len(given) < count:
        raise CommandError(f"{count} numbers are wanted, not {len(given)}")
    return given[:count]


def _sides(resolution: list[int]) -> tuple[int, int]:
    if len(resolution) < 2 or not all(1 <= side <= _LARGEST for side in resolution[:2]):
        raise CommandError(f"a resolution is {{width, height}} of 1 to {_LARGEST} pixels, not {resolution}")
    return resolution[0], resolution[1]


def _blank(resolution: list[int]) -> Pixels:
    width, height = _sides(resolution)
    return np.full((height, width, 3), 255, np.uint8)
