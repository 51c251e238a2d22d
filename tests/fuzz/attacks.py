"""As many cases of hostile calls, or of hostile results of scripts, as wanted; the suite runs the smaller part."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from . import lua
from .calls import Victim, any_call, delays, operations
from .results import Scripts, result_of

AT_ONCE = 2000
"""Cases after which the server is made anew."""


Attack = list[tuple[int, int, tuple[str, list[Any]]]]
"""Operation, delay, and name and arguments of each call."""


def sequences(most: int = 8) -> st.SearchStrategy[Attack]:
    return st.lists(st.tuples(operations, delays, any_call), min_size=1, max_size=most)


def bounded(examples: int, **more: Any) -> settings:
    """Hypothesis without deadlines and without a database in the working directory."""
    phases = [Phase.explicit, Phase.generate, Phase.shrink]
    checks: list[Any] = list(HealthCheck)
    return settings(
        max_examples=examples,
        deadline=None,
        database=None,
        suppress_health_check=checks,
        phases=phases,
        **more,
    )


def _calls(cases: int, number: int, folder: Path) -> Iterator[int]:
    with closing(Victim(folder)) as victim:

        @seed(number)
        @bounded(cases)
        @given(sequences())
        def attack(calls: Attack) -> None:
            if victim.attacks % 20 == 0:
                victim.begin()
            victim.attacks += 1
            for operation, delay, each in calls:
                victim.endure([(operation, delay, *each)])
                done.append(1)

        done: list[int] = []
        attack()
        yield len(done)


def _results(cases: int, number: int, folder: Path) -> Iterator[int]:
    with closing(Scripts(folder)) as scripts:

        @seed(number)
        @bounded(cases)
        @given(st.data())
        def attack(data: st.DataObject) -> None:
            language = data.draw(st.sampled_from(["lua", "python"]))
            scripts.endure(language, data.draw(result_of(language)))
            done.append(1)

        done: list[int] = []
        attack()
        yield len(done)


def _lua(cases: int, number: int, _: Path) -> Iterator[int]:
    yield lua.Library(number).run(cases)


_TARGETS: dict[str, Callable[[int, int, Path], Iterator[int]]] = {
    "calls": _calls,
    "lua": _lua,
    "results": _results,
}


def run(target: str, cases: int, number: int, folder: Path) -> int:
    """Run this many examples; how many cases (calls, results) they were. Raises what was found."""
    total = 0
    for part, left in enumerate(range(cases, 0, -AT_ONCE)):
        inner = folder / str(part)
        inner.mkdir()
        total += sum(_TARGETS[target](min(left, AT_ONCE), number + part, inner))
    return total
