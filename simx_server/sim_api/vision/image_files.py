"""Image files of the workspace, and image files as strings."""

from __future__ import annotations

from pathlib import PurePosixPath

import numpy as np

from simx_server.errors import CommandError
from simx_server.files import workspace
from simx_server.files.image_files import MOST_PIXELS, SUFFIXES, decoded, encoded
from simx_server.handlers.files import store_file
from simx_server.scripting.signature import to_text
from simx_server.sim_api.base import ApiPart

_RGBA = 1
"""Bit of the options: pixels have four bytes."""

_IN_MEMORY = b"@mem"
"""Follows the content of an image file that stands in place of its name."""


class ImageFileFunctions(ApiPart):
    """Functions for image files. An image is a string of RGB or RGBA bytes, the upper row first."""

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

        Partly: the given image stays as it is; V-REP 3 changed it in place.
        """
        width, height = _size(resolution)
        depth = 4 if options & _RGBA else 3
        if len(image) < width * height * depth:
            raise CommandError(
                f"{width} x {height} pixels are {width * height * depth} bytes, not {len(image)}"
            )
        pixels = np.frombuffer(image, np.uint8, width * height * depth).reshape(height, width, depth)
        return pixels[:: -1 if options & 4 else 1, :: -1 if options & 2 else 1].tobytes()

    def _content(self, name: str) -> bytes:
        path = workspace.path_within(self._sim.files.workspace, name)
        if not path.is_file():
            raise CommandError(f"there is no file '{name[:80]}' in the server's workspace")
        try:
            self._sim.limits.check("file", path.stat().st_size, "make the image smaller")
            return path.read_bytes()
        except OSError as error:
            raise CommandError(f"'{name[:80]}' cannot be read: {error.strerror}") from None


def _size(resolution: list[int]) -> tuple[int, int]:
    if len(resolution) < 2 or min(resolution[:2]) < 1 or resolution[0] * resolution[1] > MOST_PIXELS:
        raise CommandError(
            f"a resolution is {{width, height}}, up to {MOST_PIXELS} pixels, not {resolution[:2]}"
        )
    return resolution[0], resolution[1]
