"""The physics of a simulation step where nothing in it needs Python: another thread can make it."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from simx_server.joints.native._physics_step import PhysicsStep


class Apart(NamedTuple):
    """Physics steps to be made."""

    step: PhysicsStep
    steps: int
    """Number of all physics steps of the simulation step."""

    flags: int
    """The sum of the parts of a step that are wanted; see `stepper.py`."""


class Made(NamedTuple):
    """The result of these physics steps."""

    steps: int
    """Number of physics steps that were made."""

    warnings: Sequence[str]
    """Texts of MuJoCo's warnings."""


Stepping = Generator[Apart, Made, None]
"""Makes a simulation step. It yields the physics that its caller is to make, and gets what has come of it; the caller
throws MuJoCo's error into it.
"""
