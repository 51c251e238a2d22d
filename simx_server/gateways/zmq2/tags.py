"""Values of API 2 in CBOR: a closed list of tags, read with bounds, and written."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from sys import byteorder
from typing import Any, cast

from simx_client.protocol.api2.tags import (
    ARRAYS,
    COLOR,
    FUNCTION,
    MATRIX,
    OBJECT,
    OBJECTS,
    POSE,
    QUATERNION,
)
from simx_server.sim_api.object_model.values import (
    MOST_NUMBERS,
    Color,
    Matrix,
    Pose,
    Quaternion,
    Ref,
    finite_numbers,
    to_color,
)

from ..zmq.wire.messages import MAX_DEPTH, MAX_ITEMS, Reader, WireError

_TAG = 6
_LONGEST_FUNCTION = 200


@dataclass(frozen=True, slots=True)
class FunctionName:
    """A function of the client, by the name under which it is called back."""

    name: str


class TaggedReader(Reader):
    """Reads the values of one message: text is str, and byte strings are bytes."""

    __slots__ = ()

    def item(self, depth: int) -> Any:
        is_text = self._data[self.place] >> 5 == 3
        value = super().item(depth)
        return value.decode("utf-8", "surrogateescape") if is_text else value

    def _tagged(self, tag: int, depth: int) -> Any:
        if tag in ARRAYS:
            return self._array(tag)
        read = _READ.get(tag)
        if read is None:
            return super()._tagged(tag, depth)
        if tag == MATRIX:
            return self._matrix(depth)
        if self._data[self.place] >> 5 == _TAG:
            raise WireError(f"tag {tag} has another tag in it")
        try:
            return read(self.item(max(depth, MAX_DEPTH - 1)))
        except (TypeError, ValueError):
            raise WireError(f"tag {tag} has another value than it should have") from None

    def _array(self, tag: int) -> list[float]:
        """Return an array of numbers, little-endian."""
        if self._data[self.place] >> 5 != 2:
            raise WireError(f"tag {tag} holds bytes")
        numbers: array[Any] = array(ARRAYS[tag])
        data: bytes = self.item(MAX_DEPTH)
        if len(data) % numbers.itemsize or len(data) // numbers.itemsize > MAX_ITEMS:
            raise WireError(f"{len(data)} bytes are no array of numbers of {numbers.itemsize} bytes")
        self._count(len(data) // numbers.itemsize)
        numbers.frombytes(data)
        if byteorder == "big":
            numbers.byteswap()
        return numbers.tolist()

    def _matrix(self, depth: int) -> Matrix:
        """Return a matrix: a list of the two sizes, and a list or array of the numbers, row by row."""
        if self._data[self.place] >> 5 != 4:
            raise WireError("a matrix is a list of its sizes and its numbers")
        value = self.item(max(depth, MAX_DEPTH - 2))
        try:
            sizes, numbers = value
            rows, columns = sizes
            if not (_is_size(rows) and _is_size(columns)):
                raise ValueError
            return Matrix(rows, columns, finite_numbers(numbers))
        except (TypeError, ValueError):
            raise WireError("a matrix of R x C has R * C numbers") from None


def _is_size(value: Any) -> bool:
    return type(value) is int and 0 <= value <= MOST_NUMBERS


def _handle(value: Any) -> Ref:
    if value is None:
        return Ref(-1)
    if type(value) is not int or abs(value) >= 1 << 31:
        raise TypeError
    return Ref(value)


def _color(value: Any) -> Color:
    """Return a colour; the original's encoder may write its bytes as text."""
    return to_color(value.encode("utf-8", "surrogateescape") if isinstance(value, str) else value)


def _function(value: Any) -> FunctionName:
    if not isinstance(value, str) or not 0 < len(value) <= _LONGEST_FUNCTION:
        raise TypeError
    return FunctionName(value)


_READ: dict[int, Callable[[Any], Any]] = {
    MATRIX: lambda value: value,
    COLOR: _color,
    QUATERNION: lambda value: Quaternion(finite_numbers(value, 4)),
    POSE: lambda value: Pose(finite_numbers(value, 7)),
    OBJECT: _handle,
    OBJECTS: lambda value: [_handle(each) for each in value],
    FUNCTION: _function,
}


def packer() -> Callable[[Any], bytes]:
    """Return the function that writes a message. Raises ImportError: the extra ``zmq`` is missing."""
    from cbor2 import CBORTag, dumps

    def default(encoder: Any, value: Any) -> None:
        match value:
            case Ref():
                encoder.encode(CBORTag(OBJECT, value.handle))
            case Matrix():
                encoder.encode(CBORTag(MATRIX, [[value.rows, value.columns], value.numbers]))
            case Pose():
                encoder.encode(CBORTag(POSE, value.numbers))
            case Quaternion():
                encoder.encode(CBORTag(QUATERNION, value.numbers))
            case Color():
                encoder.encode(CBORTag(COLOR, value.rgba))
            case _:  # numbers and arrays of numpy; functions of scripts cannot travel
                encoder.encode(value.tolist() if hasattr(value, "tolist") else "<FUNCTION>")

    def pack(value: Any) -> bytes:
        return dumps(value, default=default)

    return pack


def travelling(value: Any) -> Any:
    """Return a result whose texts can be encoded: names of objects may have bytes other than UTF-8."""
    if isinstance(value, str):
        return value if value.isascii() else _valid(value)
    if isinstance(value, (list, tuple)):
        items = cast(Sequence[Any], value)
        return [each if type(each) in _PLAIN else travelling(each) for each in items]
    if isinstance(value, dict):
        items_of = cast(dict[Any, Any], value).items()
        return {travelling(key): travelling(each) for key, each in items_of}
    return value


_PLAIN = {int, float, bool, type(None), bytes}


def _valid(text: str) -> str | bytes:
    data = text.encode("utf-8", "surrogateescape")
    try:
        data.decode()
    except UnicodeDecodeError:
        return data
    return text
