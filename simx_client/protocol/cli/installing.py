"""Commands that install missing packages.

This project is not on a package index, so a command that names it with an extra fails outside the folder of a
clone. The packages behind an extra are on an index: a command that names those, with the versions that this
project takes, works from a clone and from a wheel. Uses the standard library only, and imports it when
something is missing.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import sys
from collections.abc import Iterable, Sequence
from operator import eq, ge, gt, le, lt, ne
from pathlib import Path

DISTRIBUTION = "simx-vrep"
CLIENT = "simx-vrep-client"
"""The distribution that holds the client alone; built in packages/client."""

ZMQ_CLIENT = "coppeliasim-zmqremoteapi-client"
"""The Python client of CoppeliaSim's ZeroMQ remote API, on a package index."""

_PYREP_SOURCES = {
    "pyrep": "git+https://github.com/stepjam/PyRep.git",
    "rlbench": "git+https://github.com/stepjam/RLBench.git",
}
"""Neither is on a package index; RLBench's installation brings PyRep."""

_EXTRA = re.compile(r"\s*(?:\band\s+)?\bextra\s*==\s*['\"](?P<extra>[\w.-]+)['\"]")
_NAME = re.compile(r"[\w.-]+")
_PYTHON = re.compile(r"python_version\s*(<=?|>=?|==|!=)\s*['\"](\d+)\.(\d+)['\"]")
_COMPARISONS = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq, "!=": ne}
_PROJECT = Path(__file__).resolve().parents[3] / "pyproject.toml"
"""Exists in a clone."""


def declared() -> dict[str | None, list[str]]:
    """Return what this project requires (None) and each of its extras, as pip takes it; empty if unknown.

    Requirements that are for other versions of Python are left out.
    """
    return {extra: [each for each in some if is_for_this_python(each)] for extra, some in _declared().items()}


def _declared() -> dict[str | None, list[str]]:
    if _PROJECT.is_file():
        import tomllib

        project = tomllib.loads(_PROJECT.read_text(encoding="utf-8"))["project"]
        return {None: project["dependencies"], **project["optional-dependencies"]}
    from importlib import metadata

    for name in (DISTRIBUTION, CLIENT):
        try:
            return by_extra(metadata.requires(name) or ())
        except metadata.PackageNotFoundError:
            continue
    return {}


def by_extra(requirements: Iterable[str]) -> dict[str | None, list[str]]:
    """Return a distribution's requirements by extra, or None for those without an extra."""
    found: dict[str | None, list[str]] = {}
    for text in requirements:
        requirement, _, marker = text.partition(";")
        extra = _EXTRA.search(marker)
        rest = _EXTRA.sub("", marker).strip()
        whole = f"{requirement.strip()}; {rest}" if rest else requirement.strip()
        found.setdefault(extra and extra["extra"], []).append(whole)
    return found


def is_for_this_python(requirement: str) -> bool:
    """Return whether every comparison of the version of Python in a requirement's marker is true here."""
    compared = _PYTHON.findall(requirement.partition(";")[2])
    return all(
        _COMPARISONS[sign](sys.version_info[:2], (int(major), int(minor))) for sign, major, minor in compared
    )


def name_of(requirement: str) -> str:
    """Return the package of a requirement."""
    found = _NAME.match(requirement)
    return found[0] if found else ""


def extra_line(extra: str) -> str:
    """Return a shell command that installs the packages of an extra."""
    return line(declared().get(extra, [f"{DISTRIBUTION}[{extra}]"]))


def package_line(*names: str) -> str:
    """Return a shell command that installs packages, in the versions that this project takes."""
    wanted = {
        name_of(each): each.partition(";")[0] for some in declared().values() for each in reversed(some)
    }
    return line([wanted.get(name, name) for name in names])


def pyrep_line(package: str) -> str:
    """Return a shell command that installs PyRep ("pyrep") or RLBench ("rlbench") without the original simulator."""
    return f"COPPELIASIM_ROOT=$(simx-run --pyrep-root) {line([_PYREP_SOURCES[package]])}"


def missing_line() -> str:
    """Return a shell command that installs all missing packages of a server."""
    needed = declared().get(None, [])
    return line([each for each in needed if not _is_installed(name_of(each))] or needed)


def missing_server() -> str:
    """Return a sentence on how to get a server where only the client is installed, otherwise an empty text."""
    if importlib.util.find_spec("simx_server") is not None:
        return ""
    return (
        f"simx-server is not installed here, only the client: install {DISTRIBUTION} instead of {CLIENT}, "
        "with the path of its clone or of its wheel"
    )


def line(requirements: Sequence[str]) -> str:
    """Return a shell command that installs these into the running Python."""
    return " ".join([_installer(), *map(_quoted, requirements)])


def _installer() -> str:
    """Return the running Python's pip: another Python may be first in the path."""
    python, uv = Path(sys.executable), shutil.which("uv")
    if importlib.util.find_spec("pip") is None and uv is not None:
        return f"uv pip install --python {_quoted(str(python))}"
    pip = shutil.which("pip")
    is_ours = pip is not None and Path(pip).parent == python.parent
    return "pip install" if is_ours else f"{_quoted(str(python))} -m pip install"


def _quoted(word: str) -> str:
    if os.name == "nt":
        return f'"{word}"' if re.search(r"[^\w.:\\/-]", word) else word
    return shlex.quote(
        word.replace("'", '"')
    )  # a marker may have either quote, and the shell takes these more easily


def _is_installed(name: str) -> bool:
    from importlib import metadata

    try:
        metadata.version(name)
    except metadata.PackageNotFoundError:
        return False
    return True
