"""Robots by name, from collections that two libraries download: ``menagerie:NAME`` and ``robot_descriptions:NAME``.

The library mujoco-menagerie has the MuJoCo Menagerie, robot_descriptions has URDF, xacro and MJCF files of many
repositories, which it clones by git. Both are in the extra `robots`, and keep what they downloaded. Only an operator
names such robots: a client must not make the server download.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterable, Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

from simx_client.protocol.cli.installing import extra_line
from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError

MENAGERIE, DESCRIPTIONS = "menagerie:", "robot_descriptions:"

_PATHS = ("URDF_PATH", "XACRO_PATH", "MJCF_PATH")
"""Names of a description's file in its module, the best first."""

_ENDINGS = ("", "_description", "_mj_description")


def is_in_collection(text: str) -> bool:
    """Return whether a text names a robot of a collection."""
    return text.startswith((MENAGERIE, DESCRIPTIONS))


def find_robot(text: str) -> Path:
    """Return the file of a robot; it is downloaded first if it is not there yet.

    Args:
        text: ``menagerie:NAME``, ``menagerie:NAME/ENTRY`` (the stem of one of its files) or
            ``robot_descriptions:NAME``.

    Raises:
        CommandError: no such robot, its library is not installed, or it cannot be downloaded.
    """
    if text.startswith(MENAGERIE):
        return _of_menagerie(text, text.removeprefix(MENAGERIE))
    module = _description(text, text.removeprefix(DESCRIPTIONS))
    path = next((Path(getattr(module, name)) for name in _PATHS if hasattr(module, name)), None)
    if path is None:
        raise CommandError(f"'{text}' has no file of a robot, only {', '.join(_paths_of(module)) or 'none'}")
    return path


def xacro_arguments(text: str) -> Mapping[str, str]:
    """Return the values that a collection gives to the arguments of a robot's xacro file. Raises CommandError."""
    if not text.startswith(DESCRIPTIONS):
        return {}
    module = _description(text, text.removeprefix(DESCRIPTIONS))
    if hasattr(module, "URDF_PATH"):
        return {}
    given: Mapping[object, object] = getattr(module, "XACRO_ARGS", {})
    return {str(name): str(value) for name, value in given.items()}


def _of_menagerie(text: str, name: str) -> Path:
    library = _library("mujoco_menagerie", text)
    name, _, entry = name.partition("/")
    if name not in library.names():
        raise _unknown(text, name, library.names())
    try:
        return Path(library.get(name).xml(entry or None))
    except library.UnknownEntryPointError as error:
        raise CommandError(f"'{text}': {error}") from None
    except (library.MenagerieError, OSError) as error:
        raise CommandError(f"'{text}' cannot be downloaded: {error}") from None


def _description(text: str, name: str) -> Any:
    library = _library("robot_descriptions", text)
    known = library.DESCRIPTIONS
    found = next((name + ending for ending in _ENDINGS if name + ending in known), None)
    if found is None:
        raise _unknown(text, name, known)
    try:
        with redirect_stdout(sys.stderr):  # the library prints what it does
            return importlib.import_module(f"robot_descriptions.{found}")
    except Exception as error:  # git, the network and the disk may fail in many ways
        raise CommandError(f"'{text}' cannot be downloaded: {' '.join(str(error).split())[:400]}") from None


def _library(name: str, text: str) -> Any:
    if importlib.util.find_spec(name) is None:
        raise CommandError(f"a library finds '{text}', which is not installed: {extra_line('robots')}")
    return importlib.import_module(name)


def _unknown(text: str, name: str, known: Iterable[str]) -> CommandError:
    names = sorted(known)
    more = f": {', '.join(names[:5])} and {len(names) - 5} more" if len(names) > 5 else ""
    return CommandError(
        f"no robot '{text}'{did_you_mean(name, names) or ';'} the collection has {len(names)}{more}"
    )


def _paths_of(module: Any) -> list[str]:
    return [name for name in dir(module) if name.endswith("_PATH")]
