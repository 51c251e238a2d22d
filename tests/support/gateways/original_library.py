"""The vendor's own compiled client, driven by ctypes: it is inside the wheel of a robotics library.

The wheel's Python module is not imported, so the library that it belongs to need not be installed.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import pytest
from other_clients import client_folder, install_line

PACKAGE = "dqrobotics-interface-coppeliasim-vrep"

ONESHOT, BLOCKING, STREAMING = 0x00000, 0x10000, 0x20000
ONESHOT_SPLIT, STREAMING_SPLIT, DISCONTINUE, BUFFER, REMOVE = 0x30000, 0x40000, 0x50000, 0x60000, 0x70000


def library_path() -> Path | None:
    """The file of the compiled client; None if it is not installed."""
    return next(client_folder(PACKAGE).rglob("_core*"), None)


needs_library = pytest.mark.skipif(
    library_path() is None, reason=f"the original client is not installed: {install_line(PACKAGE)}"
)


class Library:
    """The functions of the original's C interface that the tests call, with plain values."""

    def __init__(self) -> None:
        path = library_path()
        assert path is not None, install_line(PACKAGE)
        self._c = ctypes.CDLL(str(path))
        self._c.simxStart.argtypes = [
            ctypes.c_char_p,
            *[ctypes.c_int] * 1,
            *[ctypes.c_ubyte] * 2,
            *[ctypes.c_int] * 2,
        ]

    def start(self, port: int, *, cycle_ms: int = 5, timeout_ms: int = 10_000) -> Client:
        """Connect."""
        number = self._c.simxStart(b"127.0.0.1", port, 1, 1, timeout_ms, cycle_ms)
        assert number >= 0
        return Client(self._c, number)


class Client:
    """One connection of the library."""

    def __init__(self, c: Any, number: int) -> None:
        self._c, self.number = c, number

    def call(self, name: str, *arguments: Any, mode: int | None = BLOCKING) -> int:
        """Call a function; floats are float32. Returns the code."""
        converted = [ctypes.c_float(each) if isinstance(each, float) else each for each in arguments]
        return getattr(self._c, name)(self.number, *converted, *([] if mode is None else [mode]))

    def finish(self) -> None:
        self._c.simxFinish(self.number)

    def handle(self, name: str) -> int:
        handle = ctypes.c_int()
        assert self.call("simxGetObjectHandle", name.encode(), ctypes.byref(handle)) == 0, name
        return handle.value

    def number_of(self, name: str, *arguments: Any, mode: int = BLOCKING) -> tuple[int, float]:
        """The code and the float32 that a function gives."""
        value = ctypes.c_float()
        return self.call(name, *arguments, ctypes.byref(value), mode=mode), value.value

    def integer_of(self, name: str, *arguments: Any, mode: int = BLOCKING) -> tuple[int, int]:
        value = ctypes.c_int()
        return self.call(name, *arguments, ctypes.byref(value), mode=mode), value.value

    def floats_of(
        self, name: str, count: int, *arguments: Any, mode: int = BLOCKING
    ) -> tuple[int, list[float]]:
        values = (ctypes.c_float * count)()
        return self.call(name, *arguments, values, mode=mode), list(values)

    def ping(self) -> int:
        """The milliseconds of one exchange."""
        milliseconds = ctypes.c_int()
        assert self.call("simxGetPingTime", ctypes.byref(milliseconds), mode=None) == 0
        return milliseconds.value

    def trigger(self, steps: int = 1) -> None:
        for _ in range(steps):
            assert self.call("simxSynchronousTrigger", mode=None) == 0

    def start_stepped(self) -> None:
        assert self.call("simxSynchronous", 1, mode=None) == 0
        assert self.call("simxStartSimulation") == 0

    def string_signal(
        self, name: str, function: str = "simxGetStringSignal", mode: int = BLOCKING
    ) -> tuple[int, bytes]:
        data, size = ctypes.POINTER(ctypes.c_ubyte)(), ctypes.c_int()
        code = self.call(function, name.encode(), ctypes.byref(data), ctypes.byref(size), mode=mode)
        return code, bytes(data[: size.value]) if code == 0 else b""

    def image(
        self, handle: int, *, is_grey: bool = False, mode: int = BLOCKING
    ) -> tuple[int, tuple[int, int], bytes]:
        resolution, data = (ctypes.c_int * 2)(), ctypes.POINTER(ctypes.c_ubyte)()
        code = self.call(
            "simxGetVisionSensorImage", handle, resolution, ctypes.byref(data), int(is_grey), mode=mode
        )
        size = resolution[0] * resolution[1] * (1 if is_grey else 3)
        return code, (resolution[0], resolution[1]), bytes(data[:size]) if code == 0 else b""
