"""Describe a kept moment for the web viewer and for people: its calls, signals and joint positions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from simx_client.protocol.add_ons.past import PastCall
from simx_client.protocol.commands import ANSWERED
from simx_server.history import Moment
from simx_server.service.monitoring.log_of_calls import Called, Cut, short

_MOST_SIGNALS = 200
_MOST_LETTERS = 400
"""Letters of a call, and of its results."""


def past_call(called: Called) -> PastCall:
    """Return a call as it is written in a program, with the names of its arguments."""
    command = ANSWERED.get(called.function)
    names = [argument.name for argument in command.arguments] if command is not None else []
    arguments = [
        f"{names[number]}={_shown(value)}" if number < len(names) else _shown(value)
        for number, value in enumerate(called.arguments)
    ]
    text = f"{called.function}({', '.join(arguments)})"
    return {
        "client": called.client,
        "call": _cut(f"{text} as a stream" if called.is_stream else text),
        "results": _cut(_results(called, [value.name for value in command.results] if command else [])),
        "has_failed": called.has_failed,
        "only_reads": called.only_reads,
    }


def _results(called: Called, names: list[str]) -> str:
    if called.results is None:
        return "no answer yet"
    if called.has_failed:
        return ", ".join(map(str, called.results)) or "failed: there is no value"
    if len(names) != len(called.results):
        names = []
    return ", ".join(
        f"{names[number]}={_shown(value)}" if names else _shown(value)
        for number, value in enumerate(called.results)
    )


def _shown(value: Any) -> str:
    """Return a value as in a program; clients send most numbers with seven digits."""
    if isinstance(value, float):
        return f"{value:.7g}"
    if isinstance(value, list):
        return f"[{', '.join(map(_shown, value))}]"  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, Cut):
        return value.described(_shown(value.start))
    return repr(value)


def _cut(text: str) -> str:
    return text if len(text) <= _MOST_LETTERS else f"{text[: _MOST_LETTERS - 1]}…"


def past_signals(
    signals: tuple[Mapping[str, int], Mapping[str, float], Mapping[str, bytes]],
) -> dict[str, int | float | str]:
    """Return the signals of a moment by name, texts shortened."""
    shown: dict[str, Any] = {**signals[0], **signals[1]}
    shown |= {name: repr(short(value)) for name, value in signals[2].items()}
    return dict(list(shown.items())[:_MOST_SIGNALS])


def past_joints(moment: Moment) -> dict[str, float]:
    """Return the positions (rad, m) of joints with one number, by name; tendons are left out."""
    positions = moment.state[1:]  # the time stands first
    return {
        binding.name: float(positions[binding.qpos])
        for binding in moment.joints.bindings.values()
        if binding.element == "joint" and binding.kind != "ball"
    }
