"""How windows of a script travel to the web viewer: maps of MessagePack in the buffers of an add-on of the server.

==========  ==================================  ==============================================================
function    who, and what goes                  answer
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
"""As simxCallScriptFunction counts script types."""

EXCHANGE, SHOWN, ACT = "exchange", "shown", "act"

OWNER = "owner"
"""A text of the script's making, by which it is known."""

WINDOWS, EVENTS, IS_WATCHED, KNOWN, EVENT = "windows", "events", "is_watched", "known", "event"

NUMBER, TITLE, TEXT, TRACKBARS, IMAGE = "number", "title", "text", "trackbars", "image"
"""Of a window: int, two texts, [[label, value, minimum, maximum], ...], JPEG or None for no news."""

VERSION = "version"
"""Counts a window's images, for viewers."""

KEY, DRAGGED, CLOSED = "key", "dragged", "closed"

LARGEST_IMAGE = 1 << 20
"""Bytes."""
