"""One kind of the simulator's numbered parameters: getters, setters, and the errors for all other numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from simx_server.errors import CommandError, Unsupported

_V = TypeVar("_V")


@dataclass(frozen=True, slots=True)
class Parameter(Generic[_V]):
    """Getter and setter of one parameter; None where reading or setting is not possible."""

    get: Callable[[], _V] | None
    set: Callable[[_V], None] | None = None


class Table(Generic[_V]):
    """All parameters of one kind."""

    def __init__(self, kind: str, entries: dict[int, Parameter[_V]]) -> None:
        self._kind = kind
        self._entries = entries

    def get(self, number: int) -> _V:
        """Return a parameter's value. Raises CommandError that lists the known numbers."""
        get = self._entries.get(number, Parameter(None)).get
        if get is None:
            raise CommandError(f"{self._kind} parameter {number} cannot be read; {self._list('get')}")
        return get()

    def set(self, number: int, value: _V) -> None:
        """Set a parameter. Raises CommandError that lists the numbers that can be set."""
        put = self._entries.get(number, Parameter(None)).set
        if put is None:
            raise CommandError(f"{self._kind} parameter {number} cannot be set; {self._list('set')}")
        put(value)

    def _list(self, what: str) -> str:
        known = [str(n) for n, entry in sorted(self._entries.items()) if getattr(entry, what) is not None]
        return "those that can: " + (", ".join(known) or "none")


def only(value: _V, reason: str) -> Parameter[_V]:
    """Return a parameter with one fixed value; setting another value is not possible, for this reason."""

    def put(wanted: _V) -> None:
        if wanted != value:
            raise Unsupported(f"it stays {value}: {reason}")

    return Parameter(lambda: value, put)


def kept(value: _V) -> Parameter[_V]:
    """Return a parameter without meaning here: it reads as it was set last, initially `value`."""
    values = [value]

    def put(wanted: _V) -> None:
        values[0] = wanted

    return Parameter(lambda: values[0], put)
