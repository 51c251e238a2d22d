"""Implement ``python -m simx_client watch FUNCTION ARGS...``: print the results of a reading function when
they change."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

from simx_client.calls.marshalling import Marshal
from simx_client.connection.connection import Connection
from simx_client.errors import SimxError
from simx_client.protocol import constants as c
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, USAGE
from simx_client.protocol.cli.parser import seconds
from simx_client.protocol.commands import Command, Place

from . import connecting
from .command_parser import command_parser, program
from .one_call import Refused, alive, ask, handle_of, parse_words
from .values.arguments import WrongUse, add_arguments, check, command_named, parse
from .values.formatting import as_record, as_text

PAUSE = 0.01
"""Seconds between two polls of a stream without news; short compared to a simulation step."""

EXAMPLES = """\
examples:
  python -m simx_client watch simxGetJointPosition UR5_joint1
  python -m simx_client watch simxGetObjectPosition Cuboid --every 1
  python -m simx_client watch simxGetObjectOrientation Cuboid --every 0.2 --count 5 --json
Each line begins with the simulation time in seconds. Ctrl-C ends it.
exit codes: 0 all lines are there, 1 the function failed or the simulator went away, 2 wrong usage, 130 Ctrl-C
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "watch",
        "Stream what a reading function gives, and print a line whenever it changes.",
        examples=EXAMPLES,
        usage="FUNCTION [ARGS...] [--every SECONDS] [--count N] [--at SIMULATOR] [--json]",
    )
    add_arguments(parser, "one that reads, as simxGetObjectPosition")
    parser.add_argument(
        "--every",
        type=seconds,
        metavar="SECONDS",
        help="print a line at this interval of wall time, changed or not",
    )
    parser.add_argument("--count", type=int, metavar="N", help="exit after this number of lines")
    connecting.add_flags(parser)
    return parser


def main(argv: Sequence[str]) -> int:
    """Print up to the number of lines; return the exit code."""
    parser = make_parser()
    options = parse_words(parser, argv)
    if options.count is not None and options.count < 1:
        parser.error("--count: valid: a whole number from 1")
    try:
        command = _reading(options.function)
        check(command, options.arguments)
        with connecting.connected(options.at, options.timeout) as (client, connection):
            arguments = parse(command, options.arguments, partial(handle_of, client))
            ask(client, command, arguments)  # a refusal is printed now, with its reason
            for number, (instant, values) in enumerate(
                _values(connection, Marshal(command), tuple(arguments), options.every), 1
            ):
                sys.stdout.write(_line(command, instant, values, as_json=options.json) + "\n")
                sys.stdout.flush()
                if number == options.count:
                    break
    except WrongUse as error:
        sys.stderr.write(f"{error}\n")
        return USAGE
    except SimxError as error:
        sys.stderr.write(f"{error}\n")
        return FAILURE
    return DONE


def _reading(name: str) -> Command:
    command = command_named(name)
    if (
        command.place is not Place.REMOTE
        or not command.only_reads
        or command.gives_image
        or not command.results
    ):
        raise WrongUse(
            f"{name} cannot be watched; valid: functions that only read, such as simxGetJointPosition, "
            f"and for images {program()} image"
        )
    return command


def _values(
    connection: Connection, marshal: Marshal, arguments: tuple[Any, ...], every: float | None
) -> Iterator[tuple[float, list[Any]]]:
    """Yield simulation time (s) and results: when they change, or at an interval in seconds of wall time.

    Raises Refused when the results end.
    """
    connection.invoke(marshal, arguments, c.simx_opmode_streaming)
    deadline = time.monotonic() + connection.timeout
    due, before = 0.0, None
    while True:
        code, *values = connection.invoke(marshal, arguments, c.simx_opmode_buffer)
        now = time.monotonic()
        if not alive(connection):
            raise Refused(f"the simulator at {connection.where} went away", c.simx_return_novalue_flag)
        if code == 0:
            deadline = now + connection.timeout
            if now >= due if every else values != before:
                due = max(due + every, now) if every and due else now + (every or 0.0)
                before = values
                yield connection.last_command_time_ms / 1000, values
                continue
        elif code & c.simx_return_remote_error_flag:
            raise Refused(
                f"{marshal.command.name}: the simulator refuses it by now; its reason is above", code
            )
        elif now > deadline:
            raise Refused(f"{marshal.command.name}: no value within {connection.timeout:g} s", code)
        time.sleep(PAUSE)


def _line(command: Command, instant: float, values: Sequence[Any], *, as_json: bool) -> str:
    if as_json:
        return json.dumps({"time": instant, **as_record(command, values)})
    return f"{instant:.3f}  " + "  ".join(map(as_text, values))
