"""Every command of the table with arguments that mean no good: the server lives, and others notice nothing."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from fuzz.attacks import Attack, bounded, sequences
from fuzz.calls import COMMANDS, Victim, call, delays, operations
from hypothesis import given
from hypothesis import strategies as st
from seeds import many

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def victim(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Victim]:
    each = Victim(tmp_path_factory.mktemp("victim"))
    yield each
    each.close()


def test_every_command_survives_every_kind_of_argument(victim: Victim) -> None:
    for command in COMMANDS:

        @bounded(many(3), derandomize=True)
        @given(st.lists(st.tuples(operations, delays, call(command)), min_size=1, max_size=4))
        def attack(calls: Attack) -> None:
            victim.endure([(operation, delay, *each) for operation, delay, each in calls])

        victim.begin()
        attack()


@bounded(many(14), derandomize=True)
@given(calls=sequences())
def test_sequences_of_hostile_calls_leave_the_server_sound(victim: Victim, calls: Attack) -> None:
    victim.begin()
    for operation, delay, each in calls:
        victim.endure([(operation, delay, *each)])


def test_what_nobody_foresaw_is_noticed(victim: Victim, monkeypatch: pytest.MonkeyPatch) -> None:
    victim.begin()

    def fail(*_: object) -> None:
        raise RuntimeError("on purpose")

    monkeypatch.setattr(victim.world.parts.signals, "get_float", fail)
    with pytest.raises(AssertionError, match="on purpose"):
        victim.endure([(0, 0, "simxGetFloatSignal", ["a"])])
    victim.begin()
