"""State logs: a run as an MCAP file, which viewers of robot data open. See docs/pictures-of-a-run.md.

`state_log` listens to a simulation on the physics thread and copies little; `mcap_file` writes on a thread of its own
what `messages` makes of that. `places` knows where objects are, `shapes` what they look like, and `packed` serialises
a message that is sent again and again with other numbers.
"""

from .state_log import StateLog

__all__ = ["StateLog"]
