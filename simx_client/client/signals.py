"""Signals: named values shared by clients and scripts, in three kinds."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Generic, SupportsFloat, SupportsIndex, TypeVar

from simx_client.calls.answers import Answer
from simx_client.calls.strict import Strict
from simx_client.connection.calls import Calls
from simx_client.errors import NoSuchSignal

from .channel import Channel

T = TypeVar("T")
D = TypeVar("D")

Value = SupportsIndex | SupportsFloat | str | bytes | bytearray
"""NumPy's numbers are included."""


class _Named(ABC, Strict, Generic[T]):
    """Mapping methods built on brackets that raise NoSuchSignal."""

    __slots__ = ()

    @abstractmethod
    def __getitem__(self, name: str) -> T: ...

    def __contains__(self, name: str) -> bool:
        return self.get(name, None) is not None

    def get(self, name: str, default: D) -> T | D:
        """Return a value, or the default when the signal is not set."""
        try:
            return self[name]
        except NoSuchSignal:
            return default


class _OfKind(_Named[T]):
    """Signals of one kind with the methods of a dictionary; each access is one message."""

    __slots__ = ("_channel", "_clear", "_get", "_kind", "_put", "_read")

    def __init__(
        self,
        kind: str,
        channel: Channel,
        get: Callable[[Calls, str], Answer[Any]],
        put: Callable[[Calls, str, T], object],
        clear: Callable[[Calls, str], object],
        read: Callable[[Any], T],
    ) -> None:
        self._channel, self._get, self._put, self._clear = channel, get, put, clear
        self._kind, self._read = kind, read

    def __repr__(self) -> str:
        return f"<{self._kind} signals {self._channel.state}>"

    def __getitem__(self, name: str) -> T:
        answer = self._channel.try_all(lambda calls: self._get(calls, name))
        if answer.code:
            raise NoSuchSignal([answer.failure])
        return self._read(answer.value)

    def __setitem__(self, name: str, value: T) -> None:
        _check(name)
        self._channel.send(lambda calls: self._put(calls, name, value))

    def __delitem__(self, name: str) -> None:
        """Clear a signal; succeeds if it is not set."""
        _check(name)
        self._channel.send(lambda calls: self._clear(calls, name))


class Signals(_Named[int | float | str]):
    """All signals. ``signals["x"] = 1`` sets an integer signal, ``1.0`` a float signal, text or bytes a string signal.

    With these brackets a name has one kind: setting it clears signals of the other kinds. Where a script of the scene
    expects a kind, use ``ints``, ``floats``, ``strings`` or ``buffers``, which leave the other kinds unchanged.
    """

    __slots__ = ("_channel", "buffers", "floats", "ints", "strings")

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        integers = Calls.simxGetIntegerSignal, Calls.simxSetIntegerSignal, Calls.simxClearIntegerSignal
        floats = Calls.simxGetFloatSignal, Calls.simxSetFloatSignal, Calls.simxClearFloatSignal
        strings = Calls.simxGetStringSignal, Calls.simxSetStringSignal, Calls.simxClearStringSignal
        self.ints = _OfKind[int]("integer", channel, *integers, int)
        self.floats = _OfKind[float]("float", channel, *floats, float)
        self.strings = _OfKind[str]("string", channel, *strings, _text)
        """String signals as text."""

        self.buffers = _OfKind[bytes]("string", channel, *strings, bytes)
        """String signals as bytes, such as packed numbers."""

    def __repr__(self) -> str:
        return f"<Signals {self._channel.state}>"

    def __getitem__(self, name: str) -> int | float | str:
        """Return the value in the kind that is set; one message. Raises NoSuchSignal for none, ValueError for
        several."""
        answers = self._channel.try_all(
            lambda calls: (
                calls.simxGetIntegerSignal(name),
                calls.simxGetFloatSignal(name),
                calls.simxGetStringSignal(name),
            )
        )
        found = [answer.value for answer in answers if not answer.code]
        if len(found) > 1:
            raise ValueError(
                f"signal {name!r} is set in {len(found)} kinds; take signals.ints, signals.floats or signals.strings"
            )
        if not found:
            raise NoSuchSignal([answer.failure for answer in answers])
        value = found[0]
        return _text(value) if isinstance(value, bytearray) else value

    def __setitem__(self, name: str, value: Value) -> None:
        _check(name)

        def note(calls: Calls) -> None:
            self._clear(calls, name)
            if isinstance(value, (str, bytes, bytearray)):
                calls.simxSetStringSignal(name, value)
            elif isinstance(value, SupportsIndex):
                calls.simxSetIntegerSignal(name, value)
            else:
                calls.simxSetFloatSignal(name, value)

        self._channel.send(note)

    def __delitem__(self, name: str) -> None:
        """Clear a signal in all kinds; succeeds if it is not set."""
        _check(name)
        self._channel.send(lambda calls: self._clear(calls, name))

    def _clear(self, calls: Calls, name: str) -> None:
        calls.simxClearIntegerSignal(name)
        calls.simxClearFloatSignal(name)
        calls.simxClearStringSignal(name)


def _check(name: str) -> None:
    """Raise ValueError for an empty name, which the legacy functions take for all signals, or ignore."""
    if not name:
        raise ValueError("a signal needs a name; got an empty text")


def _text(data: bytes | bytearray) -> str:
    return data.decode("utf-8", "surrogateescape")
