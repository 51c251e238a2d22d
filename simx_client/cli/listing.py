"""Implement ``python -m simx_client list``: list all live simulators as a table or as JSON."""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Sequence

from simx_client.connection.discovery import Found, find_servers, silent_servers
from simx_client.protocol import roster
from simx_client.protocol.cli.exit_codes import DONE, FAILURE

from . import discovery_flags
from .command_parser import command_parser

HEAD = ("REALM", "HOST", "PORTS", "PID", "SCENE", "STATE", "CLIENTS", "REAL TIME", "CORE", "AGE")
NO_ANSWER = "no answer"


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "list", "List the live simulators: those of this host, or those behind the given routers."
    )
    discovery_flags.add_flags(parser)
    return parser


def main(argv: Sequence[str]) -> int:
    """List the simulators; return 0 also without any, 1 if a router or server could not be reached."""
    parser = make_parser()
    options = parser.parse_args(argv)
    logging.basicConfig(stream=sys.stderr, format="%(message)s")
    endpoints = discovery_flags.endpoints(parser, options)
    is_local = not endpoints
    found, unreachable = find_servers(roster.endpoints() if is_local else endpoints, options.timeout)
    if options.json:
        sys.stdout.write(json.dumps([_record(server) for server in found], indent=1) + "\n")
    else:
        sys.stdout.write("\n".join(_table(found)) + "\n")
    if is_local:
        sys.stderr.writelines(f"{sentence}\n" for sentence in silent_servers(unreachable))
        return DONE
    for place in unreachable:
        sys.stderr.write(f"{place.reason}; check the address, and that the router runs\n")
    return FAILURE if unreachable else DONE


def _record(server: Found) -> dict[str, object]:
    """Return the record of a simulator; only ``state`` if it did not answer."""
    status = server.status
    if status is None:
        return {"realm": server.realm, "endpoint": server.endpoint, "state": NO_ANSWER}
    return {
        "realm": server.realm,
        "endpoint": server.endpoint,
        "host": status.host,
        "ports": status.ports,
        "pid": status.process_id,
        "scene": status.scene,
        "state": status.state,
        "clients": status.clients,
        "real_time_factor": round(status.real_time_factor, 3),
        "core_share": round(status.core_share, 3),
        "age": round(status.age, 1),
        "version": status.server,
    }


def _table(found: Sequence[Found]) -> list[str]:
    if not found:
        return ["no simulators"]
    rows = [HEAD, *map(_row, found)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]


def _row(server: Found) -> tuple[str, ...]:
    status = server.status
    if status is None:
        return (server.realm, *[""] * 4, NO_ANSWER, *[""] * 4)
    return (
        server.realm,
        status.host,
        ",".join(map(str, status.ports)),
        str(status.process_id),
        status.scene,
        status.state,
        str(status.clients),
        f"{status.real_time_factor:.2f} x" if status.state == "running" else "",
        f"{status.core_share:.0%}",
        age(status.age),
    )


def age(seconds: float) -> str:
    """Format a duration in its largest unit that gives a whole number."""
    whole = int(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min"
    return f"{whole // 3600} h" if whole < 86400 else f"{whole // 86400} d"
