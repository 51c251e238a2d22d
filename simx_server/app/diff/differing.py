"""Find the first difference of two recordings, and print it."""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Iterator
from typing import Any

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_server.errors import CommandError, StartError
from simx_server.recording.comparing import Course, Difference, first_difference
from simx_server.recording.replayed import Divergence
from simx_server.settings.settings import Settings

from .named_state import Departure, Named, departures, state_after

_SHOWN = 10
"""Quantities, and calls, that are listed."""


def print_difference(options: argparse.Namespace, program: str) -> int:
    """Compare two recordings and print the first difference. Returns the exit code.

    Args:
        options: the values of the flags.
        program: the command as it was called, for messages.
    """
    logging.basicConfig(level=logging.ERROR, format="%(message)s")
    try:
        one, other = Course.of(options.one), Course.of(options.other)
        difference = first_difference(one, other)
        states = None
        if difference is not None and difference.ended is None and not options.no_replay:
            settings = Settings(allow_code=options.allow_code)
            states = (
                state_after(one.path, difference.step, settings),
                state_after(other.path, difference.step, settings),
            )
    except Divergence as problem:
        sys.stderr.write(
            f"{program}: a recording does not replay here: {problem}; compare with --no-replay\n"
        )
        return FAILURE
    except (CommandError, StartError) as error:
        sys.stderr.write(f"{program}: {error}\n")
        return FAILURE
    for each in (one, other):
        if each.damage:
            sys.stderr.write(
                f"{program}: '{each.path}': {each.damage}; only what is before it was compared\n"
            )
    if options.json:
        print(json.dumps(_record(one, difference, states)))
    else:
        print("\n".join(_lines(one, other, difference, states)))
    return DONE if difference is None else DIVERGED


def _lines(
    one: Course, other: Course, difference: Difference | None, states: tuple[Named, Named] | None
) -> Iterator[str]:
    if difference is None:
        yield f"equal: all {len(one.steps)} simulation steps have the same positions and velocities"
        return
    yield from _where(difference, states)
    if states is not None:
        yield from _what(departures(*states))
    if difference.call_step is None:
        yield "clients did the same in both up to there"
    elif difference.call_step == difference.step:
        yield "clients did something else before this step"
    else:
        yield f"clients did something else for the first time before step {difference.call_step}"
    for path, calls in zip((one.path, other.path), difference.calls, strict=True):
        # Later acts may follow from the first one that differs.
        shown = calls[-_SHOWN:] if difference.call_step is None else calls[:_SHOWN]
        yield f"  {path}: " + ("; ".join(shown) or "nothing")


def _where(difference: Difference, states: tuple[Named, Named] | None) -> Iterator[str]:
    if difference.ended is not None:
        yield f"equal in {difference.step - 1} simulation steps; then '{difference.ended}' ends"
        return
    when = "" if states is None else f", {states[0].time:.3f} s after the start of its run"
    yield f"different from step {difference.step}{when}: {', '.join(difference.quantities)}"


def _what(found: list[Departure]) -> Iterator[str]:
    # An object that one of them lacks has several quantities, and one line.
    differences = list(dict.fromkeys(map(_how, found)))
    yield from differences[:_SHOWN]
    if len(differences) > _SHOWN:
        yield f"  and {len(differences) - _SHOWN} more"
    if not found:
        yield "  no object that a program can name differs"


def _how(departure: Departure) -> str:
    owner, name, unit = departure.quantity
    one, other = departure.one, departure.other
    if one is None or other is None:
        return f"  {owner}: only in the {'second' if one is None else 'first'} recording"
    size = f"{departure.size:.3g} {unit}".rstrip()
    return f"  {owner}: {name} differs by {size}\n    {_numbers(one)} and {_numbers(other)}"


def _numbers(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:.9g}" for value in values)


def _record(one: Course, difference: Difference | None, states: tuple[Named, Named] | None) -> dict[str, Any]:
    if difference is None:
        return {"equal": True, "steps": len(one.steps)}
    found = [] if states is None else departures(*states)
    return {
        "equal": False,
        "step": difference.step,
        "time": None if states is None else states[0].time,
        "ended": None if difference.ended is None else str(difference.ended),
        "quantities": difference.quantities,
        "objects": [
            {
                "object": each.quantity.owner,
                "quantity": each.quantity.name,
                "unit": each.quantity.unit,
                "one": each.one,
                "other": each.other,
            }
            for each in found
        ],
        "call_step": difference.call_step,
        "calls": difference.calls,
    }
