"""Write the lock files: ``python packages/lock.py UV``, which ``make lock`` does.

A lock has every package that an installation takes, with its version and the hashes of its files, for all systems and
for each Python from the least one on: markers tell them apart. pip reads it with ``--require-hashes`` and takes
nothing else, from whichever index or mirror. uv resolves, since pip cannot do so for other systems than its own.
"""

from __future__ import annotations

import hashlib
import re
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

REPOSITORY = Path(__file__).resolve().parents[1]
FOLDER = REPOSITORY / "packages" / "locks"

TO_BUILD = ("hatchling>=1.26", "editables>=0.5")
"""They build this project itself, which pip installs after the lock, without a network."""

OF_CLIENT = ("eclipse-zenoh", "msgpack", "numpy")
"""What a client of a class needs: its requirements, and numpy for the scripts that people have."""

LOCKS = ("setup", "server", "client")
"""For ``make setup``; for a server, as in the container; for the students of a class."""

_SIGN = "# made from requirements with the SHA-256 "


def requirements(lock: str, project: dict[str, Any] | None = None) -> list[str]:
    """Return the requirements that a lock fulfils, sorted.

    Args:
        lock: one of `LOCKS`.
        project: the table ``project`` of pyproject.toml; None reads it.
    """
    if project is None:
        project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    needed: list[str] = project["dependencies"]
    if lock == "client":
        needed = [each for each in needed if re.split(r"[^\w.-]", each, maxsplit=1)[0] in OF_CLIENT]
    elif lock == "setup":
        extras = project["optional-dependencies"]
        needed = [*needed, *extras["demo"], *extras["dev"]]
    return sorted([*needed, *TO_BUILD, f"python {project['requires-python']}"])


def path_of(lock: str) -> Path:
    """Return the file of a lock."""
    return FOLDER / f"{lock}.lock"


def sign(wanted: Sequence[str]) -> str:
    """Return the first line of a lock that fulfils these requirements."""
    return _SIGN + hashlib.sha256("\n".join(wanted).encode()).hexdigest()


def write(uv: str) -> None:
    """Resolve all locks anew, the first one to the newest versions and the others to the same."""
    FOLDER.mkdir(exist_ok=True)
    for lock in LOCKS:
        *wanted, python = sorted(requirements(lock), key=lambda each: each.startswith("python "))
        least = python.rpartition("=")[2]
        command = [
            *(uv, "pip", "compile", "-", "--quiet", "--universal", "--python-version", least),
            *("--generate-hashes", "--no-emit-index-url", "--no-header", "--no-annotate"),
            "--no-strip-extras",  # pip takes the newest release of a package without the extra that another one needs
            *(() if lock == LOCKS[0] else ("--constraint", str(path_of(LOCKS[0])))),
        ]
        text = subprocess.run(
            command, input="\n".join(wanted), stdout=subprocess.PIPE, text=True, check=True
        ).stdout
        head = f"{sign(requirements(lock))}\n# `make lock` renews it; install with pip install --require-hashes -r\n"
        path_of(lock).write_text(head + text, encoding="utf-8")
        print(f"{path_of(lock).relative_to(REPOSITORY)}: {text.count('==')} packages")


if __name__ == "__main__":
    write(sys.argv[1])
