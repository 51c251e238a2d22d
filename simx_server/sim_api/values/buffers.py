"""Packed numbers and images, converted as a whole: `transformBuffer`."""

from __future__ import annotations

import base64
import binascii
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import MOST_TEXTS
from simx_server.sim_api.base import ApiPart

_NUMBERS: dict[int, str] = {0: "u1", 1: "i1", 2: "<u2", 3: "<i2", 4: "<u4", 5: "<i4", 6: "<f4", 7: "<f8"}
"""sim.buffer_uint8 to sim.buffer_double, and their names in numpy."""

_PIXELS: dict[int, tuple[int, ...]] = {8: (0, 1, 2), 9: (2, 1, 0), 10: (0, 1, 2, 3), 11: (3, 0, 1, 2)}
"""sim.buffer_uint8rgb, bgr, rgba, argb: the index of r, g, b, a for each byte."""

_AT_ONCE = 1 << 20
"""Numbers between two moments at which others are served."""

_BASE64, _SPLIT, _CLAMP = 12, 13, 256

_FORMATS = (
    *("uint8", "int8", "uint16", "int16", "uint32", "int32", "float", "double"),
    *("uint8rgb", "uint8bgr", "uint8rgba", "uint8argb", "base64", "split"),
)


class BufferFunctions(ApiPart, effect="changes"):
    """Functions for buffers. Formats are sim.buffer_ constants."""

    CONSTANTS = MappingProxyType(
        {**{f"buffer_{name}": number for number, name in enumerate(_FORMATS)}, "buffer_clamp": _CLAMP}
    )

    def transformBuffer(
        self, data: bytes, in_format: int, multiplier: float, offset: float, out_format: int
    ) -> bytes | list[bytes]:
        """Return every number times `multiplier` plus `offset`, in another format; pixels keep their meaning.

        With sim.buffer_clamp added to the output format, numbers outside its range become the nearest valid one, else
        they wrap. sim.buffer_base64 returns text; sim.buffer_split returns a table of pieces of `offset` bytes.
        """
        clamp, target = bool(out_format & _CLAMP), out_format & ~_CLAMP
        if target == _SPLIT:
            size = int(offset)
            if size < 1 or len(data) % size:
                raise CommandError(f"{len(data)} bytes cannot be split into pieces of {size}")
            if len(data) // size > MOST_TEXTS:
                raise CommandError(f"at most {MOST_TEXTS} pieces are made, not {len(data) // size}")
            return [data[start : start + size] for start in range(0, len(data), size)]
        if in_format == _BASE64:
            try:
                data = base64.b64decode(data, validate=True)
            except binascii.Error as problem:
                raise CommandError(f"the data is no base64: {problem}") from None
            in_format = 0
        if target == _BASE64:
            return base64.b64encode(data)
        if in_format in _PIXELS:
            data, in_format, target = _pixels(data, in_format, target)
        elif target in _PIXELS:
            data = self._transformed(data, in_format, multiplier, offset, 0, clamp)
            channels = len(_PIXELS[target])
            if len(data) % channels:
                raise CommandError(f"{len(data)} numbers are no pixels of {channels} each")
            return data
        return self._transformed(data, in_format, multiplier, offset, target, clamp)

    def _transformed(
        self, data: bytes, in_format: int, multiplier: float, offset: float, target: int, clamp: bool
    ) -> bytes:
        """Return the numbers in another format; others are served between parts of the work."""
        size = _size_of(data, in_format)
        _check(target)
        parts: list[bytes] = []
        for start in range(0, len(data), _AT_ONCE * size):
            numbers = np.frombuffer(data[start : start + _AT_ONCE * size], _NUMBERS[in_format])
            parts.append(_to_bytes(numbers.astype(np.float64) * multiplier + offset, target, clamp))
            self._sim.interruptions.serve_others()
        return b"".join(parts)


def _check(kind: int) -> None:
    if kind not in _NUMBERS:
        raise CommandError(
            f"{kind} is no buffer format; valid are 0 to 13, sim.buffer_uint8 and what follows"
        )


def _size_of(data: bytes, kind: int) -> int:
    """Return the bytes of a number. Raises CommandError: the last number is incomplete."""
    _check(kind)
    size = np.dtype(_NUMBERS[kind]).itemsize
    if len(data) % size:
        raise CommandError(f"{len(data)} bytes are no whole count of numbers of {size} bytes")
    return size


def _to_bytes(values: NDArray[np.float64], kind: int, clamp: bool) -> bytes:
    target = np.dtype(_NUMBERS[kind])
    if target.kind == "f":
        with np.errstate(over="ignore"):
            return values.astype(target).tobytes()
    values = np.trunc(np.nan_to_num(values))
    limits = np.iinfo(target)
    if clamp:
        values = values.clip(limits.min, limits.max)
    span = 2.0 ** (8 * target.itemsize)
    return np.mod(values, span).astype(np.uint64).astype(target).tobytes()


def _pixels(data: bytes, in_format: int, target: int) -> tuple[bytes, int, int]:
    """Return pixels in the order of the target; if the target has none, the bytes unchanged."""
    order = _PIXELS[in_format]
    if len(data) % len(order):
        raise CommandError(f"{len(data)} bytes are no whole count of pixels of {len(order)} bytes")
    if target not in _PIXELS:
        return data, 0, target
    pixels = np.frombuffer(data, np.uint8).reshape(-1, len(order))
    channels = {channel: pixels[:, place] for place, channel in enumerate(order)}
    opaque = np.full(len(pixels), 255, np.uint8)
    wanted = [channels.get(channel, opaque) for channel in _PIXELS[target]]
    return np.stack(wanted, axis=1).tobytes(), 0, 0
