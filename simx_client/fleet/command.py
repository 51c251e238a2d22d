"""Implement ``python -m simx_client fleet``: servers on the hosts of a Ray cluster."""

from __future__ import annotations

import argparse
import json
import logging
import math
import os
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from typing import Any, cast

from simx_client.cli.command_parser import command_parser
from simx_client.cli.discovery_flags import add_waiting
from simx_client.connection.discovery import TIMEOUT, find_servers
from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.parser import Parser, seconds
from simx_client.transport.endpoints import check_endpoint

from . import cluster
from .member import KEPT_LINES
from .ray import FleetError, join

ADDRESS_VARIABLE = "RAY_ADDRESS"
MOST = 1000
HEAD = ("REALM", "HOST", "PID", "PORTS", "STATE", "CLIENTS", "REAL TIME", "CORE", "AGE", "RESTARTED")

RESTARTING, MISSING = "restarting", "not at the router"
"""States of servers that no client can use now."""

OWN_FLAGS = ("--realm", "--count")
"""Flags of ``simx-server`` with which a member would be another server than the fleet says."""

EXAMPLES = """\
examples:
  python -m simx_client fleet up ur5 --count 8                   on the Ray cluster of this host
  python -m simx_client fleet up ur5 --count 8 --ray head:6379 --listen tcp/0.0.0.0:7447
  python -m simx_client fleet up ur5 --count 8 -- --speed max --start
  python -m simx_client fleet status --log 20
  python -m simx_client fleet down
exit codes: 0 done, 1 failure, 2 wrong usage, 130 interrupted
"""


def main(argv: Sequence[str]) -> int:
    """Run the action; return 0, or 1 with the reason on stderr."""
    words = list(argv)
    flags = words[words.index("--") + 1 :] if "--" in words else []
    parser = make_parser()
    options = parser.parse_args(words[: words.index("--")] if "--" in words else words)
    if flags and options.run is not _up:
        parser.error(f"only `up` takes flags of simx-server, not {' '.join(flags)}")
    if own := [word for word in flags if word.partition("=")[0] in OWN_FLAGS]:
        parser.error(f"{own[0]} belongs to the fleet; use --name for realms, and --count before --")
    logging.basicConfig(stream=sys.stderr, format="%(message)s")
    try:
        with redirect_stdout(sys.stderr):  # Ray reports lost hosts on stdout
            ray = join(options.ray)
            try:
                code, text = options.run(ray, options, flags)
            finally:
                ray.shutdown()
    except (FleetError, ValueError) as error:
        sys.stderr.write(f"{error}\n")
        return FAILURE
    sys.stdout.write(text)
    return code


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the three actions."""
    parser = command_parser(
        "fleet",
        "Run servers on the hosts of a Ray cluster, which places and restarts them.",
        examples=EXAMPLES,
    )
    actions: Any = parser.add_subparsers(
        metavar="ACTION", title="actions", required=True, parser_class=cast(Any, _action_parser)
    )
    started = actions.add_parser(
        "up", help="start a fleet", description="Start a fleet. Flags of simx-server follow after --."
    )
    started.add_argument(
        "scene", metavar="SCENE", help="a file that exists on every host, or a shipped scene"
    )
    started.add_argument("--count", type=_count, default=1, metavar="N", help="servers (1)")
    routers = started.add_mutually_exclusive_group()
    routers.add_argument(
        "--connect", action="append", type=_endpoint, metavar="ENDPOINT", help="router to join, repeatable"
    )
    routers.add_argument(
        "--listen",
        type=_endpoint,
        default="tcp/127.0.0.1:7447",
        metavar="ENDPOINT",
        help="where the fleet's own router listens on the head's host, without --connect (tcp/127.0.0.1:7447)",
    )
    started.add_argument(
        "--cpus", type=_share, default=0.1, metavar="CORES", help="cores that Ray reserves for a server (0.1)"
    )
    started.add_argument(
        "--timeout",
        type=seconds,
        default=60.0,
        metavar="SECONDS",
        help="how long to wait for the start of all servers (60)",
    )
    seen = actions.add_parser(
        "status",
        help="print where its servers run, and how",
        description="Print where the servers of a fleet run, and how.",
    )
    seen.add_argument(
        "--log",
        type=_lines,
        default=0,
        metavar="LINES",
        help="also the newest lines of each log, at most 1000",
    )
    seen.add_argument(
        "--connect",
        action="append",
        type=_endpoint,
        metavar="ENDPOINT",
        help="router to ask instead of those that the servers joined",
    )
    add_waiting(seen, "answers", TIMEOUT)
    ended = actions.add_parser("down", help="end all servers", description="End all servers of a fleet.")
    for action, run in ((started, _up), (seen, _status), (ended, _down)):
        action.add_argument(
            "--name", default="fleet", help="name of the fleet; realms are NAME-0, NAME-1 (fleet)"
        )
        action.add_argument(
            "--ray",
            default=os.environ.get(ADDRESS_VARIABLE) or "auto",
            metavar="ADDRESS",
            help=f"HOST:PORT of the head of the Ray cluster ({ADDRESS_VARIABLE}; else the one of this host)",
        )
        action.set_defaults(run=run)
    return parser


def _up(ray: Any, options: argparse.Namespace, flags: Sequence[str]) -> tuple[int, str]:
    wanted = cluster.Wanted(
        options.name,
        os.path.abspath(options.scene) if os.path.exists(options.scene) else options.scene,
        options.count,
        tuple(options.connect or ()),
        options.listen,
        options.cpus,
        tuple(flags),
        options.timeout,
    )
    endpoints, servers = cluster.up(ray, wanted)
    return DONE, json.dumps({"fleet": wanted.name, "routers": endpoints, "servers": servers}) + "\n"


def _status(ray: Any, options: argparse.Namespace, flags: Sequence[str]) -> tuple[int, str]:
    found = cluster.find(ray, options.name)
    told = cluster.answers(ray, {realm: each.describe.remote() for realm, each in found.members.items()})
    # A fleet that was started with --connect has no own router.
    joined = dict.fromkeys(each for place in told.values() if place is not None for each in place["routers"])
    endpoints = options.connect or found.endpoints or list(joined)
    live, _ = find_servers(endpoints, options.timeout) if endpoints else ([], [])
    measured = {each.realm: each.status for each in live if each.status is not None}
    logs = cluster.answers(
        ray, {realm: each.log.remote(options.log) for realm, each in found.members.items()}
    )
    records = [_record(realm, place, measured.get(realm)) for realm, place in told.items()]
    code = FAILURE if any(record["state"] in (RESTARTING, MISSING) for record in records) else DONE
    if options.json:
        for record in records:
            record["log"] = logs[record["realm"]] or []
        return code, json.dumps({"routers": endpoints, "servers": records}, indent=1) + "\n"
    newest = [f"{realm}: {line}" for realm, lines in logs.items() for line in lines or ()]
    return code, "\n".join([*_table(records), *newest]) + "\n"


def _down(ray: Any, options: argparse.Namespace, flags: Sequence[str]) -> tuple[int, str]:
    return DONE, f"{cluster.down(ray, options.name)} servers ended\n"


def _record(realm: str, place: dict[str, Any] | None, status: Any) -> dict[str, Any]:
    if place is None:
        return {"realm": realm, "state": RESTARTING}
    record: dict[str, Any] = {**place, "age": round(place["age"], 1), "state": MISSING}
    if status is not None:
        record |= {
            "state": status.state,
            "clients": status.clients,
            "real_time_factor": round(status.real_time_factor, 3),
            "core_share": round(status.core_share, 3),
        }
    return record


def _table(records: Sequence[dict[str, Any]]) -> list[str]:
    keys = (
        "realm",
        "host",
        "pid",
        "ports",
        "state",
        "clients",
        "real_time_factor",
        "core_share",
        "age",
        "restarted",
    )
    rows = [HEAD, *(tuple(_shown(record.get(key)) for key in keys) for record in records)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(map(str.ljust, row, widths)).rstrip() for row in rows]


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ",".join(map(str, value))  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
    return "" if value is None else str(value)


def _action_parser(**options: Any) -> argparse.ArgumentParser:
    return Parser(
        options.pop("prog"), usage=options.pop("usage", None), description=options.pop("description", "")
    )


def _count(text: str) -> int:
    if not text.isdecimal() or not len(text) < 5 or not 1 <= int(text) <= MOST:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be used; valid: 1 to {MOST}")
    return int(text)


def _lines(text: str) -> int:
    if not text.isdecimal() or not len(text) < 5 or int(text) > KEPT_LINES:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be used; valid: 0 to {KEPT_LINES} lines")
    return int(text)


def _share(text: str) -> float:
    try:
        share = float(text)
    except ValueError:
        share = -1.0
    if not 0 <= share < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} cannot be used; valid: cores from 0, such as 0.5")
    return share


def _endpoint(text: str) -> str:
    try:
        return check_endpoint(text, "the endpoint")
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
