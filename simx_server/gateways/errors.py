"""The error of every gateway."""

from __future__ import annotations


class GatewayError(Exception):
    """The server cannot listen or connect as requested; the text says what to do."""
