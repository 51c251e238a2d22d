"""Content of a scene, as ``simx-server SCENE --tree --json`` prints it, and a search for names in it."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import SimxError
from ..protocol.cli.installing import missing_server
from ..protocol.files import is_vrep_name
from ..protocol.nearest import nearest
from .reading.texts import ANY, matches

TIMEOUT_S = 120.0
"""Time-out for loading a scene in seconds; the largest known scene takes ten."""

_INDEX = re.compile(r"\[[^\]]*\]$")


class NoScene(SimxError):
    """The scene could not be read; the text says why."""


@dataclass(frozen=True)
class SceneView:
    """One loaded scene."""

    record: dict[str, Any]

    @property
    def name(self) -> str:
        return self.record["scene"]

    @property
    def how_to_add(self) -> str:
        """Return where a custom text is added to it: a V-REP file is converted first."""
        file = str(self.record.get("file") or "")
        if not is_vrep_name(file):
            return "in the scene's file"
        return f"in the MJCF that `simx-server {shlex.quote(Path(file).name)} --convert FOLDER` writes"

    @property
    def objects(self) -> list[dict[str, Any]]:
        return self.record["objects"]

    def finds(self, text: str) -> list[dict[str, Any]]:
        """Return the objects that a name or path, possibly with unknown parts, may mean: by the server's
        rules of names."""
        plain = text.partition("@")[0]
        if plain.startswith(("/", ".", ":")):
            parts = [
                _INDEX.sub("", part)
                for part in re.split("/", plain.lstrip(":./"))
                if part not in ("", ".", "..")
            ]
            return [each for each in self.objects if parts and _is_on_path(parts, each["path"])]
        wanted = plain.removesuffix("#")
        found = [each for each in self.objects if matches(wanted, each["name"])]
        if not found and (link := re.sub(r"_(?:respondable|visual)(#\d+)?$", r"\1", wanted)) != wanted:
            found = [each for each in self.objects if matches(link, each["name"]) and each["type"] == "shape"]
        return found

    def nearest(self, text: str) -> list[str]:
        """Return up to three similar names."""
        wanted = text.strip("/.:").rpartition("/")[2].replace(ANY, "")
        return nearest(wanted, [each["name"] for each in self.objects])

    def registered(self, kind: str) -> list[str]:
        """Return names of collections, collisions, distances or custom UIs."""
        return self.record["registered"].get(kind, [])

    @property
    def scripts(self) -> list[dict[str, Any]]:
        """Return all scripts of the scene."""
        return [*self.record["main_script"], *(one for each in self.objects for one in each["scripts"])]

    def sets_signal(self, name: str) -> bool:
        """Return whether a script of the scene names a signal that may be this one."""
        known = [each for script in self.scripts for each in script["signals"]]
        return any(matches(name, each) or matches(each, name) for each in known)


def look_at(scene: str, *flags: str) -> SceneView:
    """Load the scene with a server, in a separate process, and return its content. Raises NoScene."""
    if missing := missing_server():
        raise NoScene(f"the scene {scene} cannot be looked at: {missing}")
    command = [
        sys.executable,
        "-P",
        "-m",
        "simx_server",
        scene,
        "--tree",
        "--json",
        "--log-format",
        "json",
        *flags,
    ]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT_S
        )
    except subprocess.TimeoutExpired:
        raise NoScene(f"the scene {scene} was not loaded within {TIMEOUT_S:g} s") from None
    if done.returncode:
        raise NoScene(f"the scene {scene} cannot be looked at: {_reason(done)}")
    return SceneView(json.loads(done.stdout))


def _reason(done: subprocess.CompletedProcess[str]) -> str:
    """Return the last line of its log: a record in JSON, unless it failed earlier."""
    lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
    try:
        return str(json.loads(lines[-1])["message"])
    except (ValueError, LookupError, TypeError):
        return lines[-1]


def _is_on_path(parts: list[str], path: str) -> bool:
    """Return whether the last part is the object, and the others are above it in this order."""
    names = [_INDEX.sub("", name) for name in path.strip("/").split("/")]
    if not matches(parts[-1], names[-1]):
        return False
    above = iter(names[:-1])
    return all(any(matches(part, name) for name in above) for part in parts[:-1])
