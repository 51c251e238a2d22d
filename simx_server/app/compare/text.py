"""The result of a comparison as lines for people and as one record for programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from .departures import Comparison, Departure, Tolerance
from .quantities import ANSWER, UNITS

SHOWN = 12
"""Quantities and objects that are listed."""


class Names(NamedTuple):
    """The names of the two runs."""

    one: str
    other: str


def tolerance_text(tolerances: Mapping[str, Tolerance]) -> str:
    """Return the tolerances in words."""
    return ", ".join(
        f"{name} {each.absolute:g} {UNITS[name]}".rstrip()
        + (f" + {each.share:.0%} of its range" if each.share else "")
        for name, each in tolerances.items()
    )


def lines(found: Comparison, names: Names, *, steps: bool = True) -> Iterator[str]:
    """Yield the result in lines.

    Args:
        steps: whether the program makes the simulation steps itself in both runs.
    """
    every = [*found.departures, *found.equal]
    objects = {each.quantity.owner for each in every if each.quantity.name != ANSWER}
    answers = sum(each.quantity.name == ANSWER for each in every)
    samples = max((each.samples for each in every), default=0)
    yield (
        f"compared {len(objects)} objects and the answers of {answers} calls at up to {samples} times, "
        f"{names.one} until {found.ends[0]:.3f} s, {names.other} until {found.ends[1]:.3f} s"
    )
    yield f"tolerances: {tolerance_text(found.tolerances)}"
    yield from _first(found, names)
    yield from _table(found.departures)
    yield from _others(found, names)
    yield from _calls(found, names)
    if not steps:
        yield "the program does not make the simulation steps itself, so that its timing differs from run to run"


def _first(found: Comparison, names: Names) -> Iterator[str]:
    if found.ends_early:
        yield f"ends early: {names.other} at {found.ends[1]:.3f} s, {names.one} at {found.ends[0]:.3f} s"
    if not found.departures:
        if found.equal and found.ends_early:
            yield "every quantity stays within its tolerance up to there"
        elif found.equal:
            yield "equal: every quantity stays within its tolerance"
        else:
            yield "nothing to compare: the two runs have no quantity at common times"
        return
    first = found.departures[0]
    yield f"departs first: {first.quantity} at {first.time:.3f} s, by {size_text(first, first.size)}"
    yield f"  {names.one}: {_numbers(first.one)}"
    yield f"  {names.other}: {_numbers(first.other)}"


def _table(departures: Sequence[Departure]) -> Iterator[str]:
    """Yield the first departure of each object and call, in the order of time."""
    first = first_of_each(departures)
    if not first:
        return
    yield "per object, and per call, the first quantity that departs:"
    for each in first[:SHOWN]:
        yield (
            f"  {each.time:9.3f} s  {each.quantity}: {size_text(each, each.size)}; "
            f"largest {size_text(each, each.largest)} at {each.largest_time:.3f} s"
        )
    if len(first) > SHOWN:
        yield f"  and {len(first) - SHOWN} more"


def first_of_each(departures: Sequence[Departure]) -> list[Departure]:
    """Return the first departure of each object and call."""
    found: dict[str, Departure] = {}
    for each in departures:
        found.setdefault(each.quantity.owner, each)
    return list(found.values())


def size_text(departure: Departure, size: float) -> str:
    """Return the size of a difference with its unit."""
    return f"{size:.3g} {UNITS[departure.quantity.name]}".rstrip()


def _others(found: Comparison, names: Names) -> Iterator[str]:
    departed = {each.quantity.owner for each in found.departures}
    equal = list(
        dict.fromkeys(each.quantity.owner for each in found.equal if each.quantity.owner not in departed)
    )
    if departed and equal:
        yield f"within the tolerances: {_some(equal)}"
    for name, owners in ((names.one, found.only_one), (names.other, found.only_other)):
        if owners:
            yield f"only in {name}: {_some(owners)}"
    if found.not_aligned:
        yield f"without a common time: {_some([str(each) for each in found.not_aligned])}"


def _some(words: Sequence[str]) -> str:
    rest = f" and {len(words) - SHOWN} more" if len(words) > SHOWN else ""
    return ", ".join(words[:SHOWN]) + rest


def _calls(found: Comparison, names: Names) -> Iterator[str]:
    if found.calls is None:
        return
    yield f"the program's calls depart with call {found.calls.number} of those that change something:"
    for name, call in zip(names, (found.calls.one, found.calls.other), strict=True):
        yield f"  {name}: " + (
            "no further call" if call is None else f"{str(call)[:200]} at {call.time:.3f} s"
        )


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


def record(found: Comparison) -> dict[str, Any]:
    """Return the result as JSON has it."""

    def row(each: Departure) -> dict[str, Any]:
        return {
            "object": each.quantity.owner,
            "quantity": each.quantity.name,
            "unit": UNITS[each.quantity.name],
            "time": each.time,
            "size": each.size,
            "one": each.one,
            "other": each.other,
            "largest": each.largest,
            "largest_time": each.largest_time,
            "rms": each.rms,
            "samples": each.samples,
        }

    return {
        "equal": found.is_equal,
        "ends": found.ends,
        "ends_early": found.ends_early,
        "tolerances": {
            name: {"absolute": each.absolute, "share": each.share} for name, each in found.tolerances.items()
        },
        "departures": list(map(row, found.departures)),
        "within": list(map(row, found.equal)),
        "only_one": found.only_one,
        "only_other": found.only_other,
        "calls": None
        if found.calls is None
        else {
            "number": found.calls.number,
            "one": None if found.calls.one is None else str(found.calls.one),
            "other": None if found.calls.other is None else str(found.calls.other),
        },
    }
