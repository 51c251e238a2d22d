"""Distributions as ``[randomize]`` writes them: ``"Cube.mass" = { uniform = [0.05, 0.2] }``."""

from __future__ import annotations

from typing import Any, cast

from simx_client.randomization import Choice, LogUniform, Normal, Randomize, Scale, Shift, Uniform

from .reading import Table

FORMS = (
    "a number or list, { uniform = [LOW, HIGH] }, { log_uniform = [LOW, HIGH] }, "
    "{ normal = [MEAN, DEVIATION] }, { choice = [VALUES] }, { scale = ... } or { shift = ... } of one of these"
)

_PAIRS = {"uniform": Uniform, "log_uniform": LogUniform, "normal": Normal}
_OF_SCENE = {"scale": Scale, "shift": Shift}


def read_random(table: Table) -> Randomize | None:
    """Return what is random; None for an empty table. Raises TaskError."""
    values: dict[str, Any] = {}
    for name, described in table.items():
        try:
            values[name] = _value(described)
            Randomize({name: values[name]})
        except (ValueError, TypeError) as problem:
            table.fail(name, str(problem))
    return Randomize(values) if values else None


def _value(described: Any) -> Any:
    if isinstance(described, (int, float, list)) and not isinstance(described, bool):
        return described  # pyright: ignore[reportUnknownVariableType] - `Randomize` checks it
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
