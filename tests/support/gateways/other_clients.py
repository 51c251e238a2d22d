"""Clients of other projects that tests drive the gateways with, each in a folder of its own beside the tests.

There they need no dependencies and hide no other version, so `.ci/run` does not install them into the environment.
"""

from __future__ import annotations

from pathlib import Path

from simx_client.protocol.cli.installing import line

CLIENTS = Path(__file__).parents[3] / ".clients"


def client_folder(requirement: str) -> Path:
    """Where a client belongs.

    Args:
        requirement: As pip reads it, such as `package==1.0`.
    """
    return CLIENTS / requirement


def install_line(requirement: str, *needed: str) -> str:
    """The command that puts a client there.

    Args:
        requirement: As pip reads it.
        needed: further packages that it imports.
    """
    return f"{line([requirement, *needed])} --no-deps --target .clients/{requirement}"
