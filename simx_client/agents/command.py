"""Implement ``simx mcp``: serve one agent over standard input and output."""

from __future__ import annotations

import argparse
import logging
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from simx_client.cli.command_parser import command_parser
from simx_client.errors import SimxError
from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.installing import extra_line, missing_server

from .answers import Folder
from .session import Session

EXAMPLES = """\
examples:
  python -m simx_client mcp ur5_rg2_kinect           for one agent, over stdin and stdout
  python -m simx_client mcp --folder ~/robots        files of this folder only
An agent's configuration names this command. docs/agents.md has the list of tools.
exit codes: 0 the agent has left, 1 a failure, 2 wrong usage
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "mcp", "Offer a simulation to an agent by the Model Context Protocol.", examples=EXAMPLES
    )
    parser.add_argument("scene", metavar="SCENE", nargs="?", help="a scene to load at the start")
    parser.add_argument(
        "--folder",
        metavar="DIR",
        type=Path,
        default=Path(),
        help="the only files that tools use (this folder)",
    )
    parser.add_argument(
        "--allow-code", action="store_true", help="let the agent run programs and scripts on this computer"
    )
    return parser


def main(argv: Sequence[str]) -> int:
    """Serve until the agent leaves; return the exit code."""
    options = make_parser().parse_args(argv)
    try:
        from .tools import make_server
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "mcp":
            raise
        sys.stderr.write(f"simx mcp needs the package mcp; install it: {extra_line('mcp')}\n")
        return FAILURE
    if missing := missing_server():
        sys.stderr.write(f"{missing}\n")
        return FAILURE
    if not options.folder.is_dir():
        sys.stderr.write(f"'{options.folder}' is no folder; name one with --folder\n")
        return FAILURE
    logging.basicConfig(level=logging.WARNING, stream=sys.stderr)
    with tempfile.TemporaryDirectory(prefix="simx-mcp-") as workspace:
        session = Session(Folder(options.folder), Path(workspace), allows_code=options.allow_code)
        try:
            if options.scene is not None:
                session.load(options.scene)
            make_server(session).run("stdio")
        except SimxError as error:
            sys.stderr.write(f"{error}\n")
            return FAILURE
        finally:
            session.close()
    return DONE
