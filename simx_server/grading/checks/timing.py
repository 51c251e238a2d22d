"""When an expression has to be true: ``EXPRESSION before 20``, ``always EXPRESSION``, ``EXPRESSION at end``."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from .expression import Expression, ExpressionError, Sight, parse

_FIRST = re.compile(r"(always|never)\s+")
_END = re.compile(r"\s+at\s+end\s*$")
_WORD = re.compile(r"\s+(before|after|for)\s+(\d+(?:\.\d*)?|\.\d+)\s*$")

FORMS = (
    ("EXPRESSION", "is true once"),
    ("EXPRESSION before 20", "is true once within 20 s"),
    ("EXPRESSION after 5", "is true once, later than 5 s"),
    ("EXPRESSION for 2", "is true without a break for 2 s"),
    ("EXPRESSION at end", "is true in the last step of the run"),
    ("always EXPRESSION", "is true after every step; also with before and after"),
    ("never EXPRESSION", "is true after no step"),
)
"""The forms of a check. ``before``, ``after`` and ``for`` can be combined."""

_ROUNDING = 1e-9
"""Seconds by which sums of time steps may be wrong."""


@dataclass(frozen=True, slots=True)
class Timed:
    """An expression, and when it has to be true."""

    text: str
    expression: Expression
    mode: str
    """once, always, never, or end."""

    begin: float = 0.0
    end: float = math.inf
    lasting: float = 0.0


def parse_timed(text: str) -> Timed:
    """Return the check that a text describes. Raises ExpressionError."""
    rest, mode = text.strip(), "once"
    if found := _FIRST.match(rest):
        mode, rest = found[1], rest[found.end() :]
    if found := _END.search(rest):
        if mode != "once":
            raise ExpressionError(f"{text!r}: '{mode}' and 'at end' exclude each other")
        mode, rest = "end", rest[: found.start()]
    times: dict[str, float] = {}
    while found := _WORD.search(rest):
        if found[1] in times:
            raise ExpressionError(f"{text!r}: '{found[1]}' is there twice")
        times[found[1]] = float(found[2])
        rest = rest[: found.start()]
    if mode == "end" and times:
        raise ExpressionError(f"{text!r}: 'at end' and '{next(iter(times))}' exclude each other")
    if mode in ("always", "never") and "for" in times:
        raise ExpressionError(f"{text!r}: '{mode}' and 'for' exclude each other")
    begin, end = times.get("after", 0.0), times.get("before", math.inf)
    lasting = times.get("for", 0.0)
    if begin + lasting > end:
        raise ExpressionError(f"{text!r}: there is no time after {begin:g} s and before {end:g} s for this")
    return Timed(text.strip(), parse(rest), mode, begin, end, lasting)


class Verdict:
    """The state of a check during a run."""

    def __init__(self, timed: Timed) -> None:
        self._timed = timed
        self._is_met: bool | None = {"always": True, "never": True}.get(timed.mode)
        self._last: bool | None = None
        self._has_come = False
        """There was a step in the time in which the expression counts."""

        self._since: float | None = None
        self._when: float | None = None
        """Seconds of the step that decided it."""

    def update(self, sight: Sight) -> None:
        """Look at the state after a simulation step."""
        timed, now = self._timed, sight.time
        is_true = bool(timed.expression.evaluate(sight))
        self._last = is_true
        if timed.mode == "end":
            return
        if not timed.begin - _ROUNDING <= now <= timed.end + _ROUNDING:
            self._since = None
            return
        self._has_come = True
        if timed.mode == "once":
            self._look_for_once(now, is_true)
        elif self._is_met and is_true is (timed.mode == "never"):
            self._is_met, self._when = False, now

    def _look_for_once(self, now: float, is_true: bool) -> None:
        if not is_true:
            self._since = None
            return
        if self._since is None:
            self._since = now
        if not self._is_met and now - self._since >= self._timed.lasting - _ROUNDING:
            self._is_met, self._when = True, now

    @property
    def is_met(self) -> bool:
        """Return the result, at the end of the run; a run without a step in the time that counts has met nothing."""
        if self._timed.mode == "end":
            return bool(self._last)
        return bool(self._is_met) and self._has_come

    def __str__(self) -> str:
        """Return the reason in words."""
        if self._last is None:
            return "the simulation was never started"
        if self._timed.mode == "end":
            return "true at the end" if self._last else "not true at the end"
        if not self._has_come:
            return "no simulation step was in that time"
        if self._when is not None:
            return f"{'true' if self.is_met else 'violated'} at {self._when:.2f} s"
        return "always kept" if self.is_met else "never true in that time"
