"""What may go wrong with pictures for people, and the packages that they need beyond the server's own."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class PictureError(Exception):
    """A picture or a film cannot be made; the text says why and what to do."""


def package(name: str, flag: str, extra: str) -> Any:
    """An optional package. Raises PictureError, with the line that installs it."""
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        raise PictureError(
            f"{flag} needs the package {error.name}, which is not installed; pip install 'simx-vrep[{extra}]'"
        ) from None
