"""Bounds on what agents send and receive: files of one folder, texts and images of a limited size."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from simx_client.cli.values.png import png
from simx_client.errors import SimxError

MOST_TEXT = 20_000
"""Characters of an answer."""

MOST_PIXELS = 640
"""Pixels along the larger side of an image."""


class Refused(SimxError):
    """A tool cannot do what was asked; the text says what is valid."""


class Folder:
    """The only folder whose files tools read and write."""

    def __init__(self, path: Path) -> None:
        self.path = path.resolve()

    def file(self, text: str, *, is_new: bool = False) -> Path:
        """Return a file in the folder. Raises Refused."""
        path = (self.path / text).resolve()
        if not path.is_relative_to(self.path):
            raise Refused(f"'{text}' is outside the folder {self.path}; name a file in it")
        if is_new and (path.exists() or not path.parent.is_dir()):
            raise Refused(
                f"'{text}' cannot be a new file; name one that does not exist, in a folder that does"
            )
        if not is_new and not path.is_file():
            raise Refused(f"there is no file '{text}' in {self.path}")
        return path

    def scene(self, text: str) -> str:
        """Return a scene: a file in the folder, or the name of a shipped one. Raises Refused."""
        try:
            return str(self.file(text))
        except Refused:
            if text.isidentifier():  # a name without a folder, an ending or a source
                return text
            raise


def limited(text: str) -> str:
    """Return a text, cut in the middle if it is too long."""
    if len(text) <= MOST_TEXT:
        return text
    half = MOST_TEXT // 2
    return f"{text[:half]}\n... {len(text) - MOST_TEXT} characters are left out ...\n{text[-half:]}"


def small_png(pixels: Any, *, is_colour: bool) -> bytes:
    """Return an image as PNG, with every n-th pixel if it is too large.

    Args:
        pixels: uint8, height x width (x 3), the top row first.
    """
    stride = -(-max(pixels.shape[:2]) // MOST_PIXELS)
    kept = pixels[::stride, ::stride]
    return png((row.tobytes() for row in kept), kept.shape[1], kept.shape[0], is_colour=is_colour)
