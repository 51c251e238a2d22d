"""Have PyRep's programs find simx in place of CoppeliaSim, in this process and in those that it starts."""

from __future__ import annotations

import os
from pathlib import Path

SWITCH = "SIMX_PYREP"
"""With a value other than 0, each Python of this environment makes the stand-in ready: `simx_pyrep.pth` does so."""


def stand_in_for_pyrep(arguments: str) -> None:
    """Make the stand-in ready.

    Args:
        arguments: more flags of ``simx-server``, as in a shell; empty for those of the environment.
    """
    from simx_client.pyrep import activate
    from simx_client.pyrep.worlds import ARGUMENTS

    os.environ[SWITCH] = "1"
    if arguments:
        os.environ[ARGUMENTS] = arguments
    activate()


def pyrep_root() -> Path:
    """Return the folder that PyRep's installation takes for CoppeliaSim's."""
    from simx_client.pyrep.root import root_folder

    return root_folder()
