"""State logs: a run as an MCAP file, which viewers of robot data open. See docs/pictures-of-a-run.md.

`state_log` listens to a simulation on the physics thread and copies little; `mcap_file` writes the `messages` on a
separate thread. `poses` finds the poses of objects, `shapes` their appearance, and `packed` serialises a message that
is sent repeatedly with other numbers.
"""

from .state_log import StateLog

__all__ = ["StateLog"]
