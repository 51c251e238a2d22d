"""Messages for windows of a script in the web viewer: maps of MessagePack in the buffers of an add-on of the server.

==========  ==================================  ==============================================================
function    caller, and content                 answer
==========  ==================================  ==============================================================
exchange    the script: `OWNER`, all `WINDOWS`  `IS_WATCHED`, `EVENTS` since the last time
shown       a viewer: versions that it has      `WINDOWS`, images where there is a newer one
act         a viewer: `OWNER` and an event
==========  ==================================  ==============================================================

An event is a list: ``["key", code]``, ``["dragged", window, label, value]``, ``["closed", window]``.
"""

from __future__ import annotations

ADD_ON = "simxWindows"
ADD_ON_TYPE = 2
"""Script type, as in simxCallScriptFunction."""

EXCHANGE, SHOWN, ACT = "exchange", "shown", "act"

OWNER = "owner"
"""Text that identifies the script."""

WINDOWS, EVENTS, IS_WATCHED, KNOWN, EVENT = "windows", "events", "is_watched", "known", "event"

NUMBER, TITLE, TEXT, TRACKBARS, IMAGE = "number", "title", "text", "trackbars", "image"
"""Fields of a window: int, two texts, [[label, value, minimum, maximum], ...], JPEG or None for no news."""

VERSION = "version"
"""Number of a window's images so far, for viewers."""

KEY, DRAGGED, CLOSED = "key", "dragged", "closed"

LARGEST_IMAGE = 1 << 20
"""Maximum size in bytes."""
