"""Exit codes of the programs. ``docs/operators/operations.md`` describes them."""

from __future__ import annotations

DONE = 0
FAILURE = 1
USAGE = 2
"""Wrong usage, as in argparse."""

DIVERGED = 3
"""A replay reached another state than the recording."""

INCOMPLETE = 4
"""A replay reached the same states as far as the recording could be read, or had nothing to compare."""

INTERRUPTED = 130
"""As in shells after Ctrl-C."""

UNREAD = 141
"""As in shells when the reader of the output has exited."""
