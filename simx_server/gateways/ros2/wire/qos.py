"""Quality of service of a topic: what subscribers are shown, and whether late ones get the last messages."""

from __future__ import annotations

from dataclasses import dataclass

DEFAULT_DEPTH = 42
"""Messages that rmw_zenoh keeps unless told otherwise; it writes nothing for this number."""


@dataclass(frozen=True, slots=True)
class Qos:
    """A profile. Everything else has the default: keep last, automatic liveliness, no deadline, no end of life."""

    depth: int = 10
    """Messages that are kept: for late subscribers of a transient-local topic, for the server of one it subscribes."""

    is_reliable: bool = True
    is_transient_local: bool = False
    """Late subscribers get the last messages."""

    def text(self) -> str:
        """Return the profile as it stands in a token: `reliability:durability:history,depth:…`, defaults empty."""
        reliability = "" if self.is_reliable else "2"
        durability = "1" if self.is_transient_local else ""
        depth = "" if self.depth == DEFAULT_DEPTH else str(self.depth)
        return f"{reliability}:{durability}:,{depth}:,:,:,,"


SENSOR_DATA = Qos(depth=5, is_reliable=False)
"""For images and scans: the newest counts."""

TRANSFORMS = Qos(depth=100)
"""Of ``/tf``."""

LATCHED = Qos(depth=1, is_transient_local=True)
"""Of ``/tf_static`` and ``/robot_description``."""

CLOCK = Qos(depth=1, is_reliable=False)
"""Of ``/clock``."""

LOG = Qos(depth=1000, is_transient_local=True)
"""Of ``/rosout``."""

EVENTS = Qos(depth=1000)
"""Of ``/parameter_events``."""
