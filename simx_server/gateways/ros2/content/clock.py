"""``/clock``: simulated time, for nodes with ``use_sim_time``."""

from __future__ import annotations

from collections.abc import Iterable

from ..endpoints import Content, Message, Moment, Offer, Published
from ..wire.qos import CLOCK


class Clock(Content):
    """Publishes the time of each simulation step.

    While the simulation is paused the last time is repeated; while it is stopped that is 0.
    """

    def offers(self) -> Iterable[Offer]:
        yield Published("/clock", "rosgraph_msgs/msg/Clock", _clock, CLOCK)


def _clock(moment: Moment) -> Message:
    return {"clock": moment.stamp}
