"""How fast blocking calls follow one another: as fast as the server answers, or by V-REP's clock.

In V-REP a blocking call of a running simulation took up to a simulation step, and many programs have a loop that
nothing else paces: they poll until a value no longer changes, or move an object a little with each blocking set.
"""

from __future__ import annotations

import os

from simx_client.protocol.messages import Pace

VARIABLE = "SIMX_PACE"

PACES = {pace.name.lower(): pace for pace in Pace}
"""What the variable and the flag of simx-run may say."""

OLD_SCRIPTS = "repeat"
"""The pace of programs that were written for V-REP: under simx-run, and through the stand-ins for vrep.py."""


def chosen_pace() -> Pace:
    """Return the pace that ``SIMX_PACE`` names, `Pace.FREE` where it is not set.

    Raises:
        ValueError: it names none; the text says what is valid.
    """
    name = os.environ.get(VARIABLE, "").strip() or "free"
    if name not in PACES:
        raise ValueError(f"{VARIABLE}: there is no pace {name!r}; valid: {', '.join(PACES)}")
    return PACES[name]
