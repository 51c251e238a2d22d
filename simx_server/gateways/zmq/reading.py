"""The functions that a viewer may call: those of ``sim`` that read or calculate, and change nothing that others see.

A function that is not known to only read is refused, also in the other namespaces.
"""

from __future__ import annotations

import re

from .wire import EVAL

_READS = re.compile(r"(get|is|read|check|pack|unpack|build|multiply|interpolate|invert|bool)[A-Z0-9]")

_TAKES = frozenset(
    ("getSimulatorMessage", "getUIEventButton", "getRandom", "getConfigForTipPose", "checkIkGroup")
)
"""Functions with such names that take a message, a click or a random number away from others, or search for seconds."""

_MORE = frozenset(
    (
        *(
            "wait",
            "waitForSignal",
            "jointGetForce",
            "visitTree",
            "tubeStatus",
            "poseToMatrix",
            "matrixToPose",
        ),
        *("rotateAroundAxis", "copyMatrix", "copyTable", "resamplePath", "abgToYpr", "yprToAbg"),
        *("alphaBetaGammaToYawPitchRoll", "yawPitchRollToAlphaBetaGamma"),
    )
)
"""Functions with other names that only read or calculate."""


def only_reads(full_name: str) -> bool:
    """Return whether a viewer may call a function, given with its namespace."""
    space, _, name = full_name.partition(".")
    if space == "zmqRemoteApi":
        return full_name != EVAL
    return space == "sim" and (name in _MORE or (bool(_READS.match(name)) and name not in _TAKES))
