"""Messages about past steps of a run: maps of MessagePack in the buffers of an add-on of the server.

==========  ==================================  ==============================================================
function    integers                            answer
==========  ==================================  ==============================================================
keepPast    whether to                          keeps past steps for this client, until it leaves
pastKept                                        `Kept`
pastStep    step                                `PastStep`, of the step or of the last kept one before it
goOn        step                                `GoneOn`: a new run from the end of that step, paused
==========  ==================================  ==============================================================
"""

from __future__ import annotations

from typing import Literal, TypedDict

ADD_ON = "simxView"
ADD_ON_TYPE = 2
"""Script type, as in simxCallScriptFunction."""

KEEP, KEPT, STEP, GO_ON = "keepPast", "pastKept", "pastStep", "goOn"

State = Literal["stopped", "running", "paused"]


class Kept(TypedDict):
    """The steps that are kept of the present run, or of the last one."""

    now: tuple[State, float, int]
    """The present state, time and number of steps."""

    is_on: bool
    """Whether the following steps are kept."""

    first: int
    last: int
    """Steps; -1: none is kept."""

    version: int
    """Changes when later steps than the first ones are gone."""

    time_step: float
    seconds: float
    size: int
    """Bytes."""


class PastCall(TypedDict):
    """A call of a client in a past simulation step."""

    client: str
    call: str
    """Function and arguments as they are written in a program, shortened."""

    results: str
    """The returned values; the reason of a failed call; empty: no result."""

    has_failed: bool
    only_reads: bool


class PastStep(TypedDict):
    """A past simulation step, without its state."""

    step: int
    time: float
    calls: list[PastCall]
    """Those after the step before, until the end of this one, in order."""

    calls_left_out: int
    call_before: int
    """The last step before this one with a call that changes something; -1: none."""

    call_after: int
    signals: dict[str, int | float | str]
    joints: dict[str, float]
    """Positions by name, of joints with one number; rad or m."""


class GoneOn(TypedDict):
    """A new run, paused."""

    step: int
    time: float
    restarted: list[str]
    """Scripts that have started again, without the values of their variables."""
