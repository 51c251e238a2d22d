"""Implement ``python -m simx_client status``: print health and metrics of simulators."""

from __future__ import annotations

import argparse
import json
import logging
import re
import sys
import time
from collections.abc import Sequence
from typing import NamedTuple

from simx_client.cli import discovery_flags
from simx_client.cli.command_parser import command_parser, program
from simx_client.cli.listing import NO_ANSWER
from simx_client.connection.discovery import Measured, Unreachable, measure_servers, silent_servers
from simx_client.protocol import roster
from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.parser import seconds
from simx_client.protocol.zenoh.keys import check_chunk
from simx_client.transport.endpoints import ServerAddress

from .prometheus import exposition
from .text import description

CLEAR = "\x1b[H\x1b[2J"
"""Clears a terminal."""

EXAMPLES = """\
examples:
  python -m simx_client status                       all servers of this host and user
  python -m simx_client status 19997                 the one at a port
  python -m simx_client status lab-3 --connect tcp/router:7447
  python -m simx_client status --watch 2             again every two seconds
  python -m simx_client status --prometheus > simx.prom
exit codes: 0 all asked have answered, 1 one did not or there is none, 2 wrong usage, 130 interrupted
"""


class Where(NamedTuple):
    """Meaning of the argument WHERE."""

    endpoints: tuple[str, ...]
    """Empty: those of the flags, else of this host."""

    realm: str | None
    """None: all realms."""


def where(text: str) -> Where:
    """Parse PORT, HOST:PORT, REALM, REALM@HOST:PORT or a Zenoh endpoint. Raises ValueError for other texts."""
    if re.fullmatch(r"[a-z][a-z0-9-]*/\S+", text):
        return Where((text,), None)
    name, at, address = text.rpartition("@")
    realm = check_chunk(name) if at else None
    if not address:
        return Where((), realm)
    host, colon, port = address.rpartition(":")
    if port.isdecimal() and int(port) <= 65535:
        return Where(ServerAddress.at(host or "127.0.0.1", int(port)).endpoints, realm)
    if colon or at:
        raise ValueError(f"{address!r} is not HOST:PORT")
    return Where((), check_chunk(text))


def main(argv: Sequence[str]) -> int:
    """Request and print the status; return 0 if all answered, 1 if one did not or there is none."""
    parser = make_parser()
    options = parser.parse_args(argv)
    logging.basicConfig(stream=sys.stderr, format="%(message)s")
    named = discovery_flags.endpoints(parser, options)
    try:
        place = where(options.where) if options.where else Where((), None)
    except ValueError as error:
        parser.error(
            f"WHERE: {error}; valid: PORT, HOST:PORT, REALM, REALM@HOST:PORT, or an endpoint such as tcp/pc:7447"
        )
    while True:
        code = _tell(options, place, named)
        if options.watch is None:
            return code
        sys.stdout.flush()
        time.sleep(options.watch)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "status",
        "Tell whether simulators work, how fast, what is asked of them, and what fails.",
        examples=EXAMPLES,
    )
    parser.add_argument(
        "where",
        nargs="?",
        metavar="WHERE",
        help="PORT, HOST:PORT, REALM, REALM@HOST:PORT or a Zenoh endpoint (all of this host)",
    )
    discovery_flags.add_flags(parser)
    parser.add_argument("--prometheus", action="store_true", help="in Prometheus' text format")
    parser.add_argument("--watch", type=seconds, metavar="SECONDS", help="repeat until Ctrl-C")
    return parser


def _tell(options: argparse.Namespace, place: Where, named: Sequence[str]) -> int:
    endpoints = place.endpoints or named
    is_local = not endpoints
    found, unreachable = measure_servers(
        roster.endpoints() if is_local else endpoints, options.timeout, place.realm
    )
    if options.json:
        sys.stdout.write(json.dumps(list(map(_record, found)), indent=None if options.watch else 1) + "\n")
    elif options.prometheus:
        sys.stdout.write(exposition(found))
    else:
        pages = ["\n".join(description(server)) + "\n" for server in found]
        if options.watch and sys.stdout.isatty():
            sys.stdout.write(CLEAR)
        sys.stdout.write("\n".join(pages))
    problems = _problems(unreachable, place, is_local=is_local, is_found=bool(found))
    if not found and not problems:
        problems = [f"no simulator{_called(place)} is there; {program()} list shows which are"]
    sys.stderr.writelines(f"{problem}\n" for problem in problems)
    return DONE if not problems and all(server.metrics is not None for server in found) else FAILURE


def _problems(
    unreachable: Sequence[Unreachable], place: Where, *, is_local: bool, is_found: bool
) -> list[str]:
    """Return the errors of the endpoints that did not answer."""
    if place.realm is not None and is_found:
        return []  # with several endpoints, one that knows the realm is enough
    if is_local:
        return silent_servers(unreachable)
    return [f"{one.reason}; check the address, and that something runs there" for one in unreachable]


def _called(place: Where) -> str:
    return "" if place.realm is None else f" called {place.realm}"


def _record(server: Measured) -> dict[str, object]:
    if server.metrics is None:
        return {"realm": server.realm, "endpoint": server.endpoint, "state": NO_ANSWER}
    return {**server.metrics, "endpoint": server.endpoint}
