"""Image files of the workspace, and image files as strings."""

from __future__ import annotations

from pathlib import PurePosixPath

import cv2
import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.files.image_files import MOST_PIXELS, SUFFIXES, decoded, encoded
from simx_server.handlers.files import store_file
from simx_server.scripting.conversion.signature import to_text
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import writes_files

_RGBA = 1
"""Bit of the options: pixels have four bytes."""

_RGBA_OUT, _WITHIN, _COVERING, _NEAREST = 2, 4, 8, 16
"""Bits of the options of sim.getScaledImage."""

_VERTICAL, _HORIZONTAL = 0, 1

_MOST_SCALED = 1 << 20
"""Most pixels of a scaled image: a small one may be made very large."""

_IN_MEMORY = b"@mem"
"""Follows the content of an image file that stands in place of its name."""


class ImageFileFunctions(ApiPart, effect="changes"):
    """Functions for image files. An image is a string of RGB or RGBA bytes, the upper row first."""

    @writes_files
    def saveImage(
        self, image: bytes, resolution: list[int], options: int, file: str, quality: int = -1
    ) -> int | bytes:
        """Write an image into a file of the workspace and return 1; for '' or an ending alone, as '.jpg', return the
        content of the file. `options`: bit 0 RGBA. `quality`: 0 to 100, of JPEG files.
        """
        width, height = _size(resolution)
        depth = 4 if options & _RGBA else 3
        if len(image) != width * height * depth:
            raise CommandError(
                f"an image of {width} x {height} pixels has {width * height * depth} bytes, not {len(image)}"
            )
        is_bare = file == "" or file.lower() in SUFFIXES
        suffix = (file or SUFFIXES[0]).lower() if is_bare else PurePosixPath(file).suffix.lower()
        if suffix not in SUFFIXES:
            raise CommandError(f"'{file[:80]}' does not end like an image file: {', '.join(SUFFIXES)}")
        pixels = np.frombuffer(image, np.uint8).reshape(height, width, depth)
        content = encoded(pixels, suffix, quality)
        if is_bare:
            return content
        store_file(self._world, file, content)
        return 1

    def loadImage(self, options: int, file: bytes) -> tuple[bytes, list[int]]:
        """Return the pixels and the resolution of an image: a file of the workspace, or the content of a file with
        '@mem' behind it. `options`: bit 0 RGBA.
        """
        if file.endswith(_IN_MEMORY):
            content = file.removesuffix(_IN_MEMORY)
        else:
            content = self._content(to_text(file))
        pixels = decoded(content)
        rows, columns = pixels.shape[:2]
        chosen = pixels if options & _RGBA else np.ascontiguousarray(pixels[..., :3])
        return chosen.tobytes(), [columns, rows]

    def transformImage(self, image: bytes, resolution: list[int], options: int) -> bytes:
        """Return an image mirrored: with bit 1 left and right, with bit 2 up and down. `options`: bit 0 RGBA.

        In Lua the variables that hold the image get the result: CoppeliaSim changes it in place.
        """
        pixels = _pixels(image, resolution, 4 if options & _RGBA else 3)
        return pixels[:: -1 if options & 4 else 1, :: -1 if options & 2 else 1].tobytes()

    def getScaledImage(
        self, image: bytes, resolution: list[int], wanted: list[int], options: int
    ) -> tuple[bytes, list[int]]:
        """Return an image in another resolution, and that resolution.

        Options: 1 the image is RGBA, 2 the result is RGBA, 4 the ratio of width and height stays, within the wanted
        resolution, 8 it stays, and the result covers the wanted resolution, 16 the nearest pixel in place of a mean.
        """
        pixels = _pixels(image, resolution, 4 if options & _RGBA else 3)
        size = _size(wanted)
        if options & (_WITHIN | _COVERING):
            shares = [new / old for new, old in zip(size, resolution, strict=False)]
            share = min(shares) if options & _WITHIN else max(shares)
            size = _size([max(round(old * share), 1) for old in resolution[:2]])
        if size[0] * size[1] > _MOST_SCALED:
            raise CommandError(f"a scaled image has up to {_MOST_SCALED} pixels, not {size[0]} x {size[1]}")
        shrinks = size[0] < resolution[0] or size[1] < resolution[1]
        smooth = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        scaled = cv2.resize(pixels, size, interpolation=cv2.INTER_NEAREST if options & _NEAREST else smooth)
        if options & _RGBA_OUT and not options & _RGBA:
            scaled = np.dstack([scaled, np.full(scaled.shape[:2], 255, np.uint8)])
        elif options & _RGBA and not options & _RGBA_OUT:
            scaled = np.ascontiguousarray(scaled[..., :3])
        return scaled.tobytes(), list(size)

    def combineRgbImages(
        self, first: bytes, first_size: list[int], second: bytes, second_size: list[int], operation: int
    ) -> bytes:
        """Return one RGB image of two: side by side with sim.imgcomb_horizontal, the first one above the second with
        sim.imgcomb_vertical. Where they touch they must have the same number of pixels.
        """
        images = _pixels(first, first_size, 3), _pixels(second, second_size, 3)
        if operation not in (_VERTICAL, _HORIZONTAL):
            raise CommandError(
                f"the operation is sim.imgcomb_vertical ({_VERTICAL}) or sim.imgcomb_horizontal ({_HORIZONTAL}), "
                f"not {operation}"
            )
        side, word = (0, "width") if operation == _VERTICAL else (1, "height")
        if first_size[side] != second_size[side]:
            raise CommandError(
                f"both images must have the same {word}, not {first_size[side]} and {second_size[side]} pixels"
            )
        return (np.vstack(images) if operation == _VERTICAL else np.hstack(images)).tobytes()

    def _content(self, name: str) -> bytes:
        path = workspace.path_within(self._sim.files.workspace, name)
        if not path.is_file():
            raise CommandError(f"there is no file '{name[:80]}' in the server's workspace")
        try:
            self._sim.limits.check("file", path.stat().st_size, "make the image smaller")
            return path.read_bytes()
        except OSError as error:
            raise CommandError(f"'{name[:80]}' cannot be read: {error.strerror}") from None


def _pixels(image: bytes, resolution: list[int], depth: int) -> NDArray[np.uint8]:
    width, height = _size(resolution)
    if len(image) < width * height * depth:
        raise CommandError(f"{width} x {height} pixels are {width * height * depth} bytes, not {len(image)}")
    return np.frombuffer(image, np.uint8, width * height * depth).reshape(height, width, depth)


def _size(resolution: list[int]) -> tuple[int, int]:
    if len(resolution) < 2 or min(resolution[:2]) < 1 or resolution[0] * resolution[1] > MOST_PIXELS:
        raise CommandError(
            f"a resolution is {{width, height}}, up to {MOST_PIXELS} pixels, not {resolution[:2]}"
        )
    return resolution[0], resolution[1]
