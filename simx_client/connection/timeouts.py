"""Time-outs and limits of a client."""

from __future__ import annotations

DEFAULT_TIMEOUT = 5.0
"""Time-out of a blocking call in seconds, unless simxStart was given a negative time-out."""

MAX_UNANSWERED = 200
"""Batches without an answer at a time. A loop that calls faster than the server executes is slowed to the
server's pace; otherwise its calls would take effect later and later."""

WELCOME_TIMEOUT = 2.0
"""Time-out in seconds for the welcome of a program that speaks Zenoh."""

FLUSH_TIMEOUT = 0.5
"""Seconds that simxFinish waits for calls sent before, as long as the original's pause there."""

LAST_LOOK = 0.02
"""Seconds after its deadline in which a call still processes messages that have arrived."""

RETRY_PAUSE = 0.1
"""Seconds between two attempts to greet a server that came back."""

LONGEST_RETRY = 1.0
"""Maximum time-out in seconds of a greeting of a server that came back: through a router, and on a machine with all
cores busy, an answer may take longer than `RETRY_PAUSE`."""

BATCHING_TIME = 0.005
"""Seconds that oneshot sets of a stepping client may wait for its trigger, to leave with it in one message.
The original's thread sent every 5 ms, too."""

MAX_BATCHED = 256
"""Maximum number of batched sets; more are sent at once, since the calls of one message are limited."""
