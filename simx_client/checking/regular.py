"""Programs of CoppeliaSim's ZeroMQ remote API: what a server has of the functions and constants that they use.

Such a program calls the functions of the regular API (``sim.getObject``), which the server's scripts call as well. The
server that is installed here lists them; nothing of it is known in advance.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..errors import SimxError
from ..protocol.cli.installing import missing_server
from ..protocol.nearest import did_you_mean
from .places import Place
from .wants import Wants

TIMEOUT_S = 60.0
"""Time-out in seconds for the server's list."""

MISSING, NOT_HERE, STAND_IN, PARTLY = "", "no", "stand-in", "partly"
"""How much of a function there is; `MISSING` if the server does not know the name."""


class NoList(SimxError):
    """The server's list cannot be had; the text says why."""


@dataclass(frozen=True)
class Offered:
    """The names that a server offers to such programs."""

    names: Mapping[str, Mapping[str, str]]
    """For each name with its namespace: `support`, and `differs` from CoppeliaSim."""

    def support(self, name: str) -> str:
        return self.names[name]["support"] if name in self.names else MISSING

    def differs(self, name: str) -> str:
        return self.names[name]["differs"]

    def meant(self, name: str) -> str:
        """Return the end of a sentence with the nearest name of the same namespace."""
        space = name.partition(".")[0]
        known = [each for each in self.names if each.startswith(f"{space}.")]
        return did_you_mean(name, known) or "; docs/script-functions.md lists what there is"


def ask_server() -> Offered:
    """Return the list of the server that is installed here. Raises NoList."""
    if missing := missing_server():
        raise NoList(missing)
    command = [sys.executable, "-P", "-m", "simx_server", "--zmq-functions", "--json"]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=TIMEOUT_S
        )
    except subprocess.TimeoutExpired:
        raise NoList(f"simx-server did not list its functions within {TIMEOUT_S:g} s") from None
    try:
        return Offered(json.loads(done.stdout))
    except ValueError:
        raise NoList(f"simx-server did not list its functions: {done.stderr.strip()}") from None


def problems(wants: Wants, offered: Offered) -> Iterator[tuple[Place, str]]:
    """Yield (place, sentence) for each function and constant that is not available."""
    for name, place in wants.regular.items():
        support = offered.support(name)
        if support == MISSING:
            yield place, f"there is no function {name} here{offered.meant(name)}"
        elif support == NOT_HERE:
            yield place, f"{name} is an error here: {offered.differs(name)}"
    for name, place in wants.regular_constants.items():
        if offered.support(name) == MISSING:
            yield place, f"there is no constant {name} here{offered.meant(name)}"


def notes(wants: Wants, offered: Offered) -> Iterator[tuple[Place, str]]:
    """Yield (place, sentence) for each function that is accepted and has no effect."""
    for name, place in wants.regular.items():
        if offered.support(name) == STAND_IN:
            yield place, f"{name} has no effect here: {offered.differs(name)}"


def differing(wants: Wants, offered: Offered) -> Iterator[tuple[str, str]]:
    """Yield (function, difference from CoppeliaSim) for each that is implemented partly."""
    for name in wants.regular:
        if offered.support(name) == PARTLY:
            yield name, offered.differs(name)
