"""Implement ``python -m simx_client call FUNCTION ARGS...``: make one call from a shell."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from functools import partial

from simx_client.errors import SimxError
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, USAGE

from . import connecting
from .command_parser import command_parser
from .one_call import Refused, ask, handle_of, parse_words
from .values.arguments import WrongUse, add_arguments, check, command_named, parse
from .values.formatting import as_lines, as_record

EXAMPLES = """\
examples:
  python -m simx_client call simxGetJointPosition UR5_joint1
  python -m simx_client call simxSetJointTargetPosition UR5_joint1 -0.5
  python -m simx_client call simxSetObjectPosition Cuboid -1 0.3,0.2,0.5
  python -m simx_client call simxStartSimulation
  python -m simx_client call simxCallScriptFunction RG2 sim_scripttype_childscript rg2Open
  python -m simx_client call simxGetObjects sim_object_joint_type --json --at 19999
A name stands for its handle, a list is 1,2,3, a switch yes or no; the operation mode is blocking.
exit codes: 0 the function returned 0, 1 it did not or there is no simulator, 2 wrong usage
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "call",
        "Call one function of the legacy remote API, and print its results.",
        examples=EXAMPLES,
        usage="FUNCTION [ARGS...] [--at SIMULATOR] [--json]",
    )
    add_arguments(parser, "its name, as simxGetObjectPosition")
    connecting.add_flags(parser)
    return parser


def main(argv: Sequence[str]) -> int:
    """Make the call and print its results; return the exit code."""
    options = parse_words(make_parser(), argv)
    try:
        command = command_named(options.function)
        check(command, options.arguments)
        with connecting.connected(options.at, options.timeout) as (client, _):
            arguments = parse(command, options.arguments, partial(handle_of, client))
            values = ask(client, command, arguments)
    except WrongUse as error:
        sys.stderr.write(f"{error}\n")
        return USAGE
    except SimxError as error:
        if options.json:
            code = error.code if isinstance(error, Refused) else None
            sys.stdout.write(
                json.dumps({"function": options.function, "code": code, "error": str(error)}) + "\n"
            )
        sys.stderr.write(f"{error}\n")
        return FAILURE
    if options.json:
        record = {"function": command.name, "code": 0, "results": as_record(command, values)}
        sys.stdout.write(json.dumps(record) + "\n")
    else:
        sys.stdout.writelines(f"{line}\n" for line in as_lines(command, values))
    return DONE
