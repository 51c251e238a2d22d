"""The simulator's own modules, which scripts require: V-REP had them in its folders `lua` and `python`.

A module is a file in `lua/` or `python/` here; dots in a module's name are folders. It runs in the sandbox of the
script that requires it, with the script's globals, so a customization module defines the script's call-backs. A file
beside the scene goes before one of the same name here.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from simx_client.protocol.api2 import objects

_SHARED = {"lua": {}, "python": {"sim_objects": Path(objects.__file__)}}
"""Modules that programs outside have too."""

_ENDINGS = {"lua": ".lua", "python": ".py"}


@cache
def own_modules(language: str) -> dict[str, Path]:
    """Return the files of the modules in a language, ``lua`` or ``python``, by name."""
    folder, ending = Path(__file__).parent / language, _ENDINGS[language]
    files = sorted(folder.rglob(f"*{ending}"))
    found = {".".join(file.relative_to(folder).parts).removesuffix(ending): file for file in files}
    return found | _SHARED[language]


def own_module(name: str, language: str) -> bytes | None:
    """Return the text of a module of the simulator's own; None: there is none of this name."""
    file = own_modules(language).get(name.removesuffix(_ENDINGS[language]).replace("/", "."))
    return None if file is None else file.read_bytes()
