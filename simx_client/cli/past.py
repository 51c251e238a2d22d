"""Implement ``python -m simx_client past [STEP]``: show past steps of a run with their calls, and go on from one."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from typing import Any, cast

import msgpack

from simx_client.errors import SimxError
from simx_client.protocol.add_ons.past import (
    ADD_ON,
    ADD_ON_TYPE,
    GO_ON,
    KEPT,
    STEP,
    GoneOn,
    Kept,
    PastCall,
    PastStep,
)
from simx_client.protocol.cli.exit_codes import DONE, FAILURE, USAGE
from simx_client.protocol.commands import ANSWERED

from . import connecting
from .command_parser import command_parser
from .one_call import ask

EXAMPLES = """\
examples:
  python -m simx_client past            the last calls that changed something, with their steps
  python -m simx_client past 2          joints, signals and all calls of step 2
  python -m simx_client past 2 --go-on  a new run from the end of this step; it is paused
A server with --history SECONDS keeps the steps, and every server while a web viewer is open.
exit codes: 0 it is shown or done, 1 it is not, 2 wrong usage
"""

_SHOWN = 20
"""Steps with calls that are listed unless --calls says otherwise."""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser with the flags of the command."""
    parser = command_parser(
        "past", "Show past steps of a run, and what clients called in them.", examples=EXAMPLES
    )
    parser.add_argument(
        "step", metavar="STEP", nargs="?", type=int, help="a step that is kept; else the last calls"
    )
    parser.add_argument(
        "--calls", metavar="N", type=int, default=_SHOWN, help=f"list the last N steps with calls ({_SHOWN})"
    )
    parser.add_argument(
        "--go-on", action="store_true", help="start a new run from the end of STEP; later steps are forgotten"
    )
    connecting.add_flags(parser)
    return parser


def main(argv: Sequence[str]) -> int:
    """Show the past, or go on from it; return the exit code."""
    options = make_parser().parse_args(argv)
    if options.go_on and options.step is None:
        sys.stderr.write("--go-on needs the step from which to go on, as in: past 2 --go-on\n")
        return USAGE
    if options.calls < 1 or (options.step is not None and options.step < 0):
        sys.stderr.write("STEP is 0 or more, and N of --calls is 1 or more\n")
        return USAGE
    try:
        with connecting.connected(options.at, options.timeout) as (client, _):
            record, lines = answer(client, options.step, go_on=options.go_on, calls=options.calls)
    except SimxError as error:
        sys.stderr.write(f"{error}\n")
        return FAILURE
    sys.stdout.write(json.dumps(record) + "\n" if options.json else "".join(f"{line}\n" for line in lines))
    return DONE


def answer(
    client: int, step: int | None, *, go_on: bool = False, calls: int = _SHOWN
) -> tuple[object, list[str]]:
    """Return what was asked for as a record and as lines.

    Args:
        step: a step that is kept; None: the last calls that changed something.
        go_on: start a new run from the end of that step.
        calls: steps with calls that are listed.

    Raises:
        SimxError: the server refused it.
    """
    if go_on and step is not None:
        gone = cast(GoneOn, _call(client, GO_ON, step))
        return gone, list(_gone_on(gone))
    if step is not None:
        past = cast(PastStep, _call(client, STEP, step))
        return past, list(_step(past))
    kept = cast(Kept, _call(client, KEPT))
    steps = _last_calls(client, kept, calls)
    return {"kept": kept, "steps": steps}, [
        *_kept(kept),
        *(line for each in steps for line in _calls_of(each)),
    ]


def _call(client: int, function: str, *integers: int) -> Any:
    answer = ask(
        client,
        ANSWERED["simxCallScriptFunction"],
        [ADD_ON, ADD_ON_TYPE, function, list(integers), [], [], b""],
    )
    return msgpack.unpackb(bytes(answer[3]), strict_map_key=False)


def _last_calls(client: int, kept: Kept, count: int) -> list[PastStep]:
    """Return the last steps with calls that changed something, in order."""
    found: list[PastStep] = []
    step = kept["last"]
    while step >= 0 and len(found) < count:
        past = cast(PastStep, _call(client, STEP, step))
        if any(not call["only_reads"] for call in past["calls"]):
            found.append(past)
        step = past["call_before"]
    return found[::-1]


def _kept(kept: Kept) -> Iterator[str]:
    if kept["last"] < 0:
        yield "no step is kept" + (
            "; start the simulation" if kept["is_on"] else "; see simx-server --history SECONDS"
        )
        return
    first, last = (f"step {kept[end]} ({kept[end] * kept['time_step']:.2f} s)" for end in ("first", "last"))
    yield f"kept: {first} to {last}, {kept['size'] / 1e6:.1f} MB"


def _calls_of(past: PastStep) -> Iterator[str]:
    for call in past["calls"]:
        if not call["only_reads"]:
            yield f"step {past['step']} ({past['time']:.2f} s)  {call['client']}: {_text(call)}"


def _step(past: PastStep) -> Iterator[str]:
    yield f"step {past['step']}, {past['time']:.3f} s"
    if past["joints"]:
        yield "joints: " + ", ".join(f"{name} {value:.6g}" for name, value in past["joints"].items())
    if past["signals"]:
        yield "signals: " + ", ".join(f"{name} {value}" for name, value in past["signals"].items())
    for call in past["calls"]:
        yield f"{call['client']}: {_text(call)}"
    if past["calls_left_out"]:
        yield f"{past['calls_left_out']} further calls are not kept"
    if not past["calls"] and not past["calls_left_out"]:
        yield "no client called anything in this step"


def _text(call: PastCall) -> str:
    results = call["results"]
    return f"{call['call']}{' failed: ' if call['has_failed'] else ' -> ' if results else ''}{results}"


def _gone_on(gone: GoneOn) -> Iterator[str]:
    yield f"a new run, paused at step {gone['step']}, {gone['time']:.3f} s; start the simulation to go on"
    for script in gone["restarted"]:
        yield f"started again, without the values of its variables: {script}"
