"""The clients of API 2 in a replay."""

from __future__ import annotations

from ..zmq.replayed import Replaying
from .clients import FIRST_HANDLE, ModelClients


class ReplayedModelClients(Replaying, ModelClients):
    """All clients of API 2 of one recording. Physics thread."""

    first_handle = FIRST_HANDLE
