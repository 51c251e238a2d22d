"""Ray, an optional package that type checkers do not need."""

from __future__ import annotations

import logging
import socket
from importlib import import_module
from typing import Any

from simx_client.errors import SimxError

NAMESPACE = "simx"
"""Namespace of all fleets in a Ray cluster."""

HEAD_WITHIN = 5.0
"""Time-out in seconds for a connection to the head of the cluster."""


class FleetError(SimxError):
    """A fleet cannot be started, found or ended; the text says what to do."""


def load_ray() -> Any:
    """Return the module.

    Raises:
        FleetError: it is not installed; the text has the line that installs it.
    """
    try:
        return import_module("ray")
    except ModuleNotFoundError as missing:
        if missing.name != "ray":
            raise
        from simx_client.protocol.cli.installing import extra_line

        raise FleetError(f"a fleet needs Ray; install on every host: {extra_line('ray')}") from None


def join(address: str) -> Any:
    """Connect to a Ray cluster; return the module.

    Args:
        address: ``HOST:PORT`` of its head, or ``auto`` for the one of this host.

    Raises:
        FleetError: there is none.
    """
    ray = load_ray()
    if address != "auto":
        _check_head(address)
    try:
        ray.init(address=address, namespace=NAMESPACE, log_to_driver=False, logging_level=logging.ERROR)
    except (ConnectionError, RuntimeError, ValueError) as error:
        raise _no_cluster(address, str(error).strip().partition("\n")[0]) from None
    return ray


def _check_head(address: str) -> None:
    """Raise FleetError if no process listens there: Ray would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), HEAD_WITHIN):
            return
    except ValueError:
        raise _no_cluster(address, "this is not HOST:PORT") from None
    except OSError as error:
        raise _no_cluster(address, error.strerror or str(error)) from None


def _no_cluster(address: str, reason: str) -> FleetError:
    place = "on this host" if address == "auto" else f"at {address}"
    return FleetError(
        f"no Ray cluster {place}: {reason}; start one with: ray start --head, or name its head with --ray HOST:PORT"
    )
