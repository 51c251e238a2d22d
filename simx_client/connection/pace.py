"""Pace of blocking calls: as fast as the server answers, or by V-REP's clock.

In V-REP a blocking call during a simulation took up to a simulation step, and many programs have a loop without
other waits: they poll until a value no longer changes, or move an object a little with each blocking set.
"""

from __future__ import annotations

import os

from simx_client.protocol.messages import Pace

VARIABLE = "SIMX_PACE"

PACES = {pace.name.lower(): pace for pace in Pace}
"""Valid values of the variable and of simx-run's flag."""

OLD_SCRIPTS = "repeat"
"""Pace of programs written for V-REP: under simx-run, and with the shims for vrep.py."""


def chosen_pace() -> Pace:
    """Return the pace that ``SIMX_PACE`` names, `Pace.FREE` if it is not set.

    Raises:
        ValueError: the variable has another value; the text says what is valid.
    """
    name = os.environ.get(VARIABLE, "").strip() or "free"
    if name not in PACES:
        raise ValueError(f"{VARIABLE}: there is no pace {name!r}; valid: {', '.join(PACES)}")
    return PACES[name]
