"""Results of grading for people and for the systems of courses.

Gradescope reads ``results.json`` with tests and scores. GitHub Classroom's reporter reads a variable ``result`` of a
step: JSON as base64. nbgrader takes the number that the last line of a cell returns: ``grade(...).points``.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator
from typing import Any

from .attempt.attempt import Attempt
from .grading import Grade, Result

_LAST = 2000
"""Characters of a program's output in a report."""


def lines_of_attempt(grade_checks: tuple[str, ...], result: Result) -> Iterator[str]:
    """Yield what an attempt has met, for people."""
    yield f"{result.name}: {result.judgement.seconds:.2f} s simulated{_took(result)}"
    if result.attempt is not None:
        if result.attempt.drawn:
            drawn = "; ".join(
                f"{name} {', '.join(f'{each:.4g}' for each in values)}"
                for name, values in result.attempt.drawn.items()
            )
            yield f"  random: {drawn}"
        for reason in (result.attempt.over, result.attempt.ended):
            if reason:
                yield f"  {reason}"
    for name, decision in zip(grade_checks, result.judgement.decisions, strict=True):
        yield f"  {'yes' if decision.is_met else 'no ':3} {name}: {decision.reason}"
    if result.attempt is not None and result.attempt.ended:
        yield from (f"  {line}" for line in _end_of_output(result.attempt))


def _end_of_output(attempt: Attempt) -> Iterator[str]:
    """Yield the last lines that a program has written."""
    if lines := attempt.output[-_LAST:].strip().splitlines()[-15:]:
        yield "the end of its output:"
        # In front of a line `|`: GitHub takes those that start with :: for commands.
        yield from (f"  | {_plain(line)}" for line in lines)


def _plain(line: str) -> str:
    """Return a line without characters that control a terminal."""
    return "".join(each if each.isprintable() or each == "\t" else repr(each)[1:-1] for each in line)


def _took(result: Result) -> str:
    return "" if result.attempt is None else f", {result.attempt.seconds:.1f} s"


def summary(grade: Grade) -> Iterator[str]:
    """Yield the points, for people."""
    for number, check in enumerate(grade.task.checks):
        points = grade.points_of(number)
        yield f"{points:6.2f} of {check.points:g}  {check.name}"
        if check.hint and not grade.has_met(number):
            yield f"               {check.hint}"
    yield f"{grade.points:6.2f} of {grade.task.points:g}  {grade.task.title}"


def as_record(grade: Grade) -> dict[str, Any]:
    """Return everything, for programs."""
    return {
        "task": grade.task.title,
        "program": grade.program,
        "points": grade.points,
        "most": grade.task.points,
        "checks": [
            {
                "name": check.name,
                "check": check.timed.text,
                "points": grade.points_of(number),
                "most": check.points,
            }
            for number, check in enumerate(grade.task.checks)
        ],
        "attempts": [_attempt(result) for result in grade.results],
    }


def _attempt(result: Result) -> dict[str, Any]:
    attempt = result.attempt
    record: dict[str, Any] = {
        "seed": result.seed,
        "seconds": result.judgement.seconds,
        "checks": [{"met": each.is_met, "reason": each.reason} for each in result.judgement.decisions],
        "film": None if result.film is None else str(result.film),
    }
    if attempt is not None:
        record |= {
            "random": dict(attempt.drawn),
            "over": attempt.over,
            "ended": attempt.ended,
            "output": attempt.output[-_LAST:],
            "recording": str(attempt.recording) if attempt.recording.exists() else None,  # if it was kept
        }
    return record


def _told(grade: Grade, number: int) -> str:
    """Return what a student reads of a check."""
    check = grade.task.checks[number]
    lines = [f"{result.name}: {result.judgement.decisions[number].reason}" for result in grade.results]
    if check.hint and not grade.has_met(number):
        lines.append(check.hint)
    return "\n".join(lines)


def as_gradescope(grade: Grade) -> dict[str, Any]:
    """Return the content of Gradescope's ``results.json``."""
    ended = [
        "\n".join([f"{result.name}: {attempt.ended}", *_end_of_output(attempt)])
        for result in grade.results
        if (attempt := result.attempt) is not None and attempt.ended
    ]
    return {
        "score": round(grade.points, 4),
        "output": "\n".join(ended) or f"{len(grade.results)} attempts",
        "tests": [
            {
                "name": check.name,
                "score": round(grade.points_of(number), 4),
                "max_score": check.points,
                "status": "passed" if grade.has_met(number) else "failed",
                "output": _told(grade, number),
            }
            for number, check in enumerate(grade.task.checks)
        ],
    }


def as_github(grade: Grade) -> str:
    """Return the line for ``$GITHUB_OUTPUT`` that GitHub Classroom's reporter reads."""
    result = {
        "version": 1,
        "status": "pass" if grade.is_full else "fail",
        "max_score": grade.task.points,
        "tests": [
            {
                "name": check.name,
                "status": "pass" if grade.has_met(number) else "fail",
                "score": round(grade.points_of(number), 4),
                "message": _told(grade, number),
                "test_code": "",
                "filename": "",
                "line_no": 0,
                "execution_time": 0,
            }
            for number, check in enumerate(grade.task.checks)
        ],
    }
    return "result=" + base64.b64encode(json.dumps(result).encode()).decode() + "\n"
