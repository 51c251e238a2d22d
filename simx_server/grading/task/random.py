"""Distributions as ``[randomize]`` writes them: ``"Cube.mass" = { uniform = [0.05, 0.2] }``."""

from __future__ import annotations

from typing import Any, cast

from simx_client.protocol.random_values import (
    Choice,
    LogUniform,
    Normal,
    Scale,
    Shift,
    Uniform,
    Value,
    check_value,
)

FORMS = (
    "a number or list, { uniform = [LOW, HIGH] }, { log_uniform = [LOW, HIGH] }, "
    "{ normal = [MEAN, DEVIATION] }, { choice = [VALUES] }, { scale = ... } or { shift = ... } of one of these"
)

_PAIRS = {"uniform": Uniform, "log_uniform": LogUniform, "normal": Normal}
_OF_SCENE = {"scale": Scale, "shift": Shift}


def read_value(name: str, described: Any) -> Value:
    """Return the random value of a property. Raises ValueError."""
    try:
        value = _value(described)
        check_value(name, value)
    except TypeError as problem:
        raise ValueError(str(problem)) from None
    return value


def _value(described: Any) -> Any:
    if isinstance(described, (int, float, list)) and not isinstance(described, bool):
        return described  # pyright: ignore[reportUnknownVariableType] - `read_value` checks it
    fields = cast("dict[str, Any]", described if isinstance(described, dict) else {})
    for word, value in list(fields.items())[:1] if len(fields) == 1 else ():
        several = cast("list[Any]", value) if isinstance(value, list) else []
        if word in _PAIRS and len(several) == 2:
            return _PAIRS[word](*several)
        if word == "choice":
            return Choice(*several)
        if word in _OF_SCENE:
            return _OF_SCENE[word](_value(value))
    raise ValueError(f"{described!r:.80} is no random value; valid: {FORMS}")
