"""The error of every gateway."""

from __future__ import annotations

from simx_server.errors import StartError


class GatewayError(StartError):
    """The server cannot listen or connect as requested; the text says what to do."""
