"""The error of bytes or values that are not the message."""

from __future__ import annotations

from simx_server.errors import CommandError


class MessageError(CommandError):
    """Bytes or values do not fit the layout of a message. The text names the message, the field and what is valid."""
