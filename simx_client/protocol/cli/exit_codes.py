"""What the programs end with. ``docs/operations.md`` says when."""

from __future__ import annotations

DONE = 0
FAILURE = 1
USAGE = 2
"""As argparse has it."""

DIVERGED = 3
"""A replay came to another state than the recording."""

INCOMPLETE = 4
"""A replay came to the same states as far as the recording could be read, or had nothing to compare."""

INTERRUPTED = 130
"""As shells have it after Ctrl-C."""

UNREAD = 141
"""As shells have it when whoever read the output has gone."""
