"""How long a client waits, and for how much."""

from __future__ import annotations

DEFAULT_TIMEOUT = 5.0
"""Seconds a blocking call waits, unless simxStart was given a negative time-out."""

MAX_UNANSWERED = 200
"""Batches that may be on the way. A loop that calls faster than the server executes is slowed down to its pace;
otherwise what it says would act later and later."""

WELCOME_TIMEOUT = 2.0
"""Seconds a program that speaks Zenoh has for its welcome."""

FLUSH_TIMEOUT = 0.5
"""Seconds that simxFinish waits for what was sent before, as long as the original's pause there."""

LAST_LOOK = 0.02
"""Seconds after its deadline that a call still takes in what has come."""

RETRY_PAUSE = 0.1
"""Seconds between two attempts to greet a server that came back."""

HOLD = 0.005
"""Seconds that oneshot sets of a client that steps may wait for its trigger, to leave with it in one message. The
original's thread sent every 5 ms, too."""

MAX_HELD = 256
"""Sets that are held so; more leave at once, for there is a limit to the calls of one message."""
