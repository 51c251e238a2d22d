"""Flags of the commands that search for live servers: where to search, and the time-out."""

from __future__ import annotations

import argparse

from simx_client.connection.discovery import TIMEOUT
from simx_client.protocol.cli.parser import seconds
from simx_client.transport.endpoints import CONNECT_VARIABLE, check_endpoint, connect_endpoints


def add_flags(parser: argparse.ArgumentParser) -> None:
    """Add ``--connect``, ``--timeout`` and ``--json``."""
    parser.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help=f"Zenoh router or server to ask, such as tcp/router:7447; repeatable ({CONNECT_VARIABLE})",
    )
    add_waiting(parser, "answers", TIMEOUT)


def add_waiting(parser: argparse.ArgumentParser, awaited: str, usual: float) -> None:
    """Add ``--timeout`` and ``--json``, which every command has that sends requests to a server."""
    parser.add_argument(
        "--timeout",
        type=seconds,
        default=usual,
        metavar="SECONDS",
        help=f"how long to wait for {awaited} ({usual:g})",
    )
    parser.add_argument("--json", action="store_true", help="as JSON, for programs")


def endpoints(parser: argparse.ArgumentParser, options: argparse.Namespace) -> list[str]:
    """Return the Zenoh endpoints given by flag or variable; empty for this host. Invalid ones end the
    program."""
    try:
        return [check_endpoint(text, "--connect") for text in options.connect or ()] or list(
            connect_endpoints()
        )
    except ValueError as error:
        parser.error(str(error))
