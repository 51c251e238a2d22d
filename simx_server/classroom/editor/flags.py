"""The flags of the editor, and the decision whether a class has one."""

from __future__ import annotations

import argparse
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

from simx_server.classroom.addresses import claim
from simx_server.confined.walls import lacking
from simx_server.settings.rules import PORT, Rule, between
from simx_server.viewer.launching import missing

from .plan import LIMIT, LIMITS, PROGRAM, USUAL_NAME, EditorPlan, limits_of

logger = logging.getLogger(__name__)

VIEWS = between(0, 100)


class NoEditor(Exception):
    """The editor was asked for, and cannot be offered; the message gives the reason."""


def add_flags(parser: argparse.ArgumentParser, typed: Callable[[Rule, str], Any]) -> None:
    """Add the flags.

    Args:
        typed: returns the function that parses the text of a flag by a rule.
    """
    group = parser.add_argument_group("the editor of the seats")
    group.add_argument(
        "--editor",
        action=argparse.BooleanOptionalAction,
        default=None,
        help="write programs in the browser, run them here (yes, if the kernel can confine them)",
    )

    def add(flag: str, rule: Rule, help: str, default: object = None, **more: Any) -> None:
        group.add_argument(
            flag, type=typed(rule, flag), metavar=rule.metavar, default=default, help=help, **more
        )

    add("--program", PROGRAM, "program that each seat starts with (an example)")
    usual = (
        f"wall={LIMITS.wall:g}, processor={LIMITS.processor:g}, memory={LIMITS.memory}, disk={LIMITS.disk}"
    )
    add("--program-limit", LIMIT, f"limit of a run, s and MB, repeatable ({usual})", action="append")
    add("--views", VIEWS, "3-D views at the same time (one for each seat, with the extra viewer)")
    add("--view-port", PORT, "port of the first 3-D view (20200); 0: free ones", 20200)


def make_plan(
    options: argparse.Namespace, seats: int, host: str, folder: Path, private: Path
) -> EditorPlan | None:
    """Return the plan of the editor that the flags ask for; None for no editor.

    Args:
        options: with the values of the flags.
        seats: number of seats.
        host: IP address at which the class listens.
        folder: holds the programs.
        private: a folder that only this user can read.

    Raises:
        NoEditor: ``--editor`` or ``--views`` cannot be had here.
        AddressError: a port is taken.
    """
    if options.editor is False:
        return None
    if lacks := lacking():
        if options.editor:
            raise NoEditor(f"no --editor here, since nothing would confine the programs: {lacks}")
        logger.warning("the class has no editor, since nothing would confine the programs: %s", lacks)
        return None
    views = seats if options.views is None else options.views
    if views and (problem := missing()):
        if options.views:
            raise NoEditor(problem.replace("--view needs", "--views needs"))
        views = 0
    ports = tuple(claim(host, options.view_port, seats, "--view-port")) if views else ()
    name, start = options.program or (USUAL_NAME, "")
    return EditorPlan(
        name, start, limits_of(options.program_limit or []), folder, private / "libraries", ports, views, host
    )
