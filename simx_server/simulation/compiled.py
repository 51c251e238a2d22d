"""Attributes of a simulation that are missing while edits wait: their first reader has the edits compiled."""

from __future__ import annotations

from typing import Generic, Protocol, TypeVar

Value = TypeVar("Value")


class _Edited(Protocol):
    def compile_edits(self) -> None: ...


class Compiled(Generic[Value]):
    """An attribute that `Simulation.hold` deletes and `Simulation.compile_edits` sets.

    Python prefers the attribute of the instance, as that of a `functools.cached_property`: while no edit waits, the
    attribute costs what any other does.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, sim: _Edited | None, owner: type) -> Value:
        if sim is None:
            raise AttributeError(f"only an instance has {self._name}")
        sim.compile_edits()
        value: Value = sim.__dict__[self._name]
        return value
