"""Extended regular expressions of POSIX, searched in a time that grows with pattern and text only.

Patterns come from other nodes, and Python's own search takes exponential time for some. Here all ways through a pattern
are followed side by side (Thompson's construction). Names have no line ends, so `^` and `$` are the ends of the text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache

MOST_CHARACTERS = 1000
"""Characters of a pattern."""

MOST_STATES = 1000
"""States that a pattern may become: repetitions with counts are written out."""

MOST_REPEATS = 255
"""The largest count in braces, which POSIX guarantees (RE_DUP_MAX)."""

_MOST_DEPTH = 50
"""Groups within each other."""

_Test = Callable[[str], bool]

_CLASSES: dict[str, _Test] = {
    "alpha": str.isalpha,
    "digit": lambda one: one in "0123456789",
    "alnum": str.isalnum,
    "upper": str.isupper,
    "lower": str.islower,
    "space": str.isspace,
    "blank": lambda one: one in " \t",
    "punct": lambda one: one.isprintable() and not one.isalnum() and not one.isspace(),
    "print": str.isprintable,
    "graph": lambda one: one.isprintable() and not one.isspace(),
    "cntrl": lambda one: ord(one) < 32 or ord(one) == 127,
    "xdigit": lambda one: one in "0123456789abcdefABCDEF",
}


class BadPattern(ValueError):
    """A pattern that is not valid; the text says why."""


@dataclass(slots=True)
class _State:
    """One state: it consumes a character that passes the test, or none.

    Attributes:
        test: of the character; None: none is consumed.
        at: "^" or "$" for a state that is passed at the start or at the end of the text only.
    """

    test: _Test | None = None
    at: str = ""
    following: tuple[int, ...] = ()


_Part = tuple[int, int]
"""First and last state of a part of the pattern."""


class Pattern:
    """A pattern that was read."""

    def __init__(self, text: str) -> None:
        """Read a pattern. Raises BadPattern."""
        if len(text) > MOST_CHARACTERS:
            raise BadPattern(f"a filter has at most {MOST_CHARACTERS} characters, not {len(text)}")
        reader = _Reader(text)
        self._first, self._last = reader.whole()
        self._states = reader.states

    def cost(self, characters: int) -> int:
        """Return the steps that a search in texts of this many characters takes at most."""
        return len(self._states) * (characters + 1)

    def is_in(self, text: str) -> bool:
        """Return whether a part of the text matches."""
        active: set[int] = set()
        for place in range(len(text) + 1):
            self._enter(self._first, active, place, len(text))
            if self._last in active:
                return True
            if place < len(text):
                passed = [
                    each
                    for each in active
                    if (test := self._states[each].test) is not None and test(text[place])
                ]
                active = set()
                for each in passed:
                    for following in self._states[each].following:
                        self._enter(following, active, place + 1, len(text))
        return False

    def _enter(self, state: int, active: set[int], place: int, end: int) -> None:
        """Add a state, and those that it leads to without a character."""
        waiting = [state]
        while waiting:
            each = waiting.pop()
            if each in active:
                continue
            found = self._states[each]
            if (found.at == "^" and place) or (found.at == "$" and place < end):
                continue
            active.add(each)
            if found.test is None:
                waiting += found.following


class _Reader:
    """Reads a pattern from left to right."""

    def __init__(self, text: str) -> None:
        self._text, self._at, self._depth = text, 0, 0
        self._brackets: dict[int, tuple[_Test, int]] = {}
        """Tests of brackets by their first characters, with what follows: copies of a part share them."""

        self.states: list[_State] = []

    def whole(self) -> _Part:
        part = self._choice()
        if self._at < len(self._text):
            raise BadPattern(f"the filter has a ) without a ( at character {self._at + 1}")
        return part

    def _new(self, test: _Test | None = None, at: str = "") -> int:
        if len(self.states) >= MOST_STATES:
            raise BadPattern("the filter has too many repetitions; use smaller counts")
        self.states.append(_State(test, at))
        return len(self.states) - 1

    def _link(self, state: int, *others: int) -> None:
        self.states[state].following += others

    def _next(self) -> str:
        return self._text[self._at] if self._at < len(self._text) else ""

    def _choice(self) -> _Part:
        parts = [self._sequence()]
        while self._next() == "|":
            self._at += 1
            parts.append(self._sequence())
        first, last = self._new(), self._new()
        for start, end in parts:
            self._link(first, start)
            self._link(end, last)
        return first, last

    def _sequence(self) -> _Part:
        first = last = self._new()
        while (one := self._next()) and one not in "|)":
            opening = self._at
            start, end = self._repeated(opening)
            self._link(last, start)
            last = end
        return first, last

    def _repeated(self, opening: int) -> _Part:
        part = self._single()
        while (one := self._next()) and one in "*+?{":
            after = self._at
            least, most = self._counts()
            rest = self._at
            part = self._repeat(part, opening, after, least, most)
            self._at = rest
        return part

    def _repeat(self, part: _Part, opening: int, after: int, least: int, most: int | None) -> _Part:
        """Return a part repeated: its text from `opening` to `after` is read again for each further copy."""
        first = last = self._new()
        copies = max(least, 1) if most is None else most
        for number in range(copies):
            start, end = part if number == 0 else self._again(opening, after)
            if number >= least:
                skip = self._new()
                self._link(last, skip)
                self._link(skip, start)
                leave = self._new()
                self._link(end, leave)
                self._link(skip, leave)
                last = leave
            else:
                self._link(last, start)
                last = end
            if most is None and number == copies - 1:
                self._link(end, start)
        return first, last

    def _again(self, opening: int, after: int) -> _Part:
        self._at = opening
        part = self._single()
        while self._at < after:
            inner = self._at
            least, most = self._counts()
            rest = self._at
            part = self._repeat(part, opening, inner, least, most)
            self._at = rest
        return part

    def _counts(self) -> tuple[int, int | None]:
        """Return the least and the greatest number of repetitions; None: no limit."""
        one = self._next()
        self._at += 1
        if one != "{":
            return {"*": (0, None), "+": (1, None), "?": (0, 1)}[one]
        text, brace, _ = self._text[self._at :].partition("}")
        low, comma, high = text.partition(",")
        if not brace or not low.isdecimal() or not (high.isdecimal() or not high):
            raise BadPattern(
                f"the filter has an invalid count at character {self._at}; valid: {{2}}, {{2,}}, {{2,4}}"
            )
        self._at += len(text) + 1
        least = int(low[:9])
        most = least if not comma else int(high[:9]) if high else None
        if max(least, most or 0) > MOST_REPEATS or (most is not None and most < least):
            raise BadPattern(
                f"the count {{{text[:20]}}} of the filter is not valid; counts are 0 to {MOST_REPEATS}"
            )
        return least, most

    def _single(self) -> _Part:
        one = self._next()
        self._at += 1
        if one == "(":
            return self._group()
        if one in "^$":
            return self._leaf(None, one)
        if one == ".":
            return self._leaf(lambda _: True)
        if one == "[":
            return self._leaf(self._bracket())
        if one in "*+?{":
            raise BadPattern(f"the filter has nothing to repeat at character {self._at}")
        if one == "\\":
            one = self._next()
            self._at += 1
            if not one:
                raise BadPattern("the filter ends with a backslash")
        return self._leaf(one.__eq__)

    def _leaf(self, test: _Test | None, at: str = "") -> _Part:
        first, last = self._new(test, at), self._new()
        self._link(first, last)
        return first, last

    def _group(self) -> _Part:
        self._depth += 1
        if self._depth > _MOST_DEPTH:
            raise BadPattern(f"the filter has more than {_MOST_DEPTH} groups within each other")
        part = self._choice()
        if self._next() != ")":
            raise BadPattern("the filter has a ( without a )")
        self._at += 1
        self._depth -= 1
        return part

    def _bracket(self) -> _Test:
        """Return a test that knows its answers: a bracket has up to a thousand parts, and counts as one state."""
        first = self._at
        if first not in self._brackets:
            is_negated = self._next() == "^"
            self._at += is_negated
            tests = list(self._bracket_tests())

            @cache
            def passes(one: str) -> bool:
                return any(test(one) for test in tests) != is_negated

            self._brackets[first] = passes, self._at
        test, self._at = self._brackets[first]
        return test

    def _bracket_tests(self) -> Iterator[_Test]:
        is_first = True
        while is_first or self._next() != "]":
            if not (one := self._next()):
                raise BadPattern("the filter has a [ without a ]")
            is_first = False
            self._at += 1
            if one == "[" and self._next() == ":":
                name, end, _ = self._text[self._at + 1 :].partition(":]")
                if not end or name not in _CLASSES:
                    raise BadPattern(
                        f"the filter has the unknown class [:{name[:20]}:]; valid: {', '.join(_CLASSES)}"
                    )
                self._at += len(name) + 3
                yield _CLASSES[name]
            elif self._next() == "-" and self._text[self._at + 1 : self._at + 2] not in ("]", ""):
                last = self._text[self._at + 1]
                self._at += 2
                if last < one:
                    raise BadPattern(f"the range {one}-{last} of the filter is empty")
                yield _between(one, last)
            else:
                yield one.__eq__
        self._at += 1


def _between(first: str, last: str) -> _Test:
    return lambda one: first <= one <= last
