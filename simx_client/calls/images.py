"""The two large values: a vision sensor's image and its depth buffer, as lists that NumPy reads directly.

Old scripts expect a plain list: signed ints -128..127 (or floats 0..1), bottom row first. They index it, loop
over it, edit it in place, feed it to ``array.array('b', ...)`` and to ``np.array(image, dtype=np.uint8)``;
the last overflows for a plain list of negative ints on NumPy 2. So the value is a ``list`` *subclass* with
``__array__``.

Filling the list is expensive (measured at 640x480x3: 6 ms, against 0.02 ms for ``np.array(image,
dtype=np.uint8)`` from the bytes), so it happens at the first access. The value passes through up to three
states, and each state is a class, because Python looks methods up on the class: methods without a guard cost
nothing.

======  ====================================  ============================================================
state   holds                                 guarded methods
======  ====================================  ============================================================
unread  received bytes and a list of Nones    all: the first one fills the list, then the state is *read*
read    received bytes and the filled list    those that change it: the first drops the bytes
edited  the list alone                        none; arrays are made from the list, so they are never stale
======  ====================================  ============================================================

Consumers written in C work if they use Python's protocols, also with an unread value. They read a list's
memory only if it is *exactly* a list (``PySequence_Fast``, ``list(x)``, ``tuple(x)``, ``f(*x)``, ``json``,
``struct.pack``, ``np.fromiter``), or ask item by item (``array.array('b', x)``). A few read the memory of any
subclass (``array.fromlist``, ``heapq``). They find the Nones of an unread value and raise TypeError: the list
has its full length from the start (0.24 ms, while the image is awaited) so that the failure is visible and
never an empty image. Any access (``image[0]``) or copy (``list(image)``) before such a call avoids it. An
edit that such a function, or ``list.append(image, 1)`` past the class, makes to a *read* value is the only
one that is not noticed.
"""

from __future__ import annotations

import functools
from collections import deque
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, ClassVar, Self

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import DTypeLike, NDArray

_CHUNK = 16384  # values converted at once: the temporary arrays then fit the processor's cache

_NONES = (None,) * 16  # multiplying a tuple of 16 takes two thirds of the time of a tuple of one

_COMPARES = ["__eq__", "__ne__", "__lt__", "__le__", "__gt__", "__ge__"]
_READS = [
    *_COMPARES,
    *("__getitem__", "__iter__", "__reversed__", "__contains__", "__repr__", "__mul__", "__rmul__"),
    *("copy", "count", "index"),
]
_EDITS = [
    *("__setitem__", "__delitem__", "__iadd__", "__imul__"),
    *("append", "extend", "insert", "pop", "remove", "clear", "sort", "reverse"),
]


class PixelList(list[Any]):
    """A sensor's image as a list of numbers; see `VisionImage` and `DepthBuffer`."""

    __slots__ = ("_received", "channels", "height", "width")

    _item_bytes: ClassVar[int] = 1
    _unread: ClassVar[Any]  # the three states: subclasses made by __init_subclass__, and the class itself
    _read: ClassVar[Any]
    _edited: ClassVar[Any]
    _spare: ClassVar[deque[Any]]  # the list made in advance, if there is one
    _last_length: ClassVar[int]
    _next_length: ClassVar[int]  # length of the last two images; 0: they differ

    width: int
    height: int
    channels: int
    _received: memoryview | None

    def __init__(
        self, values: Iterable[Any] = (), width: int = 0, height: int = 0, channels: int = 1
    ) -> None:
        """Make a value that was not received; `from_bytes` is the usual way."""
        super().__init__(values)
        self.width, self.height, self.channels = width, height, channels
        self._received = None

    def __init_subclass__(cls, *, is_state: bool = False) -> None:
        """Make the two guarded states of a kind of image; the class itself is the third, edited."""
        if not is_state:
            cls._edited = cls
            cls._spare, cls._last_length, cls._next_length = deque(maxlen=1), 0, 0
            cls._read = cls._guarded(cls, "_forget_bytes", _EDITS)
            cls._unread = cls._guarded(cls._read, "_fill", _READS + _EDITS)

    @classmethod
    def _guarded(cls, base: type[PixelList], prepare: str, names: Iterable[str]) -> type[PixelList]:
        """Return `base` with methods that first call `prepare`, which moves the value to its next state, then
        run."""

        def guard(name: str) -> Callable[..., Any]:
            def guarded(self: PixelList, *args: Any, **kwargs: Any) -> Any:
                getattr(self, prepare)()
                if name in _COMPARES and isinstance(args[0], PixelList):
                    args = (list(args[0]),)  # comparing reads the memory of the other list too
                return getattr(self, name)(*args, **kwargs)

            return functools.wraps(getattr(list, name))(guarded)

        members = {"__slots__": (), "__doc__": cls.__doc__, "__module__": cls.__module__}
        return type(cls.__name__, (base,), members | {name: guard(name) for name in names}, is_state=True)

    def _fill(self) -> None:
        """Fill the list: unread -> read. In place and in chunks: two threads that do so at once write the
        same values."""
        received, size = self._received, self._item_bytes
        assert received is not None
        for start in range(0, len(self), _CHUNK):
            part = received[start * size : (start + _CHUNK) * size]
            super().__setitem__(slice(start, start + _CHUNK), self._decode(part))
        self.__class__ = self._read

    def _forget_bytes(self) -> None:
        """Drop the bytes: read -> edited."""
        self._received = None
        self.__class__ = self._edited

    @classmethod
    def prepare(cls) -> None:
        """Make the list of the next image while it is awaited, if it is likely to have the length of the last
        two.

        A list of another length is of no use, and the one for 1920x1080 takes some 30 ms.
        """
        if cls._next_length and not cls._spare:
            cls._spare.append(cls._new(cls._next_length))

    @classmethod
    def _of_nones(cls, length: int) -> Self:
        """Return a list of Nones of this length, made in advance if possible."""
        cls._next_length = length if length == cls._last_length else 0
        cls._last_length = length
        try:
            self = cls._spare.pop()
        except IndexError:
            return cls._new(length)
        return self if len(self) == length else cls._new(length)

    @classmethod
    def _new(cls, length: int) -> Self:
        self = cls(_NONES)
        self *= length // len(_NONES)
        self += _NONES[: length % len(_NONES)]
        return self

    @classmethod
    def _from_buffer(
        cls, data: bytes | bytearray | memoryview, width: int, height: int, channels: int
    ) -> Self:
        received = memoryview(data).toreadonly().cast("B")
        values = width * height * channels
        if received.nbytes != values * cls._item_bytes:
            raise ValueError(
                f"a {width}x{height} image of {channels} channel(s) takes "
                f"{values * cls._item_bytes} bytes, got {received.nbytes}"
            )
        self = cls._of_nones(values)
        self.width, self.height, self.channels = width, height, channels
        self._received = received
        self.__class__ = cls._unread
        return self

    @property
    def array(self) -> NDArray[Any]:
        """Return the image as an array of shape (height, width) or (height, width, 3), bottom row first.

        No copy: a read-only view of the received bytes. After an edit the array is made from the list;
        ValueError if the list has another length.
        """
        flat = self._flat()
        shape = (self.height, self.width) if self.channels == 1 else (self.height, self.width, self.channels)
        if flat.size != self.height * self.width * self.channels:
            raise ValueError(
                f"the list was edited to {flat.size} values, which do not fit an image of shape {shape} any more"
            )
        return flat.reshape(shape)

    def upright(self) -> NDArray[Any]:
        """Return `array` with the top row first, as screens and OpenCV count; a read-only view too."""
        return self.array[::-1]

    def tobytes(self) -> bytes:
        """Return the values as in a message, bottom row first."""
        return bytes(self._received) if self._received is not None else self._encode()

    # list + list reads the memory of the right side, filled or not: these two fill it before
    def __add__(self, other: list[Any]) -> list[Any]:
        return list(self) + (list(other) if isinstance(other, PixelList) else other)

    def __radd__(self, other: list[Any]) -> list[Any]:
        return other + list(self)

    def __reduce__(self) -> tuple[Any, ...]:
        shape = (self.width, self.height, self.channels)
        if self._received is None:
            return self._edited, (list(self), *shape)
        return self._edited._from_buffer, (bytes(self._received), *shape)

    def _flat(self) -> NDArray[Any]:
        raise NotImplementedError

    def _encode(self) -> bytes:
        raise NotImplementedError

    def _decode(self, received: memoryview) -> list[Any]:
        raise NotImplementedError


class VisionImage(PixelList):
    """Image that ``simxGetVisionSensorImage`` returns: width*height*channels signed ints.

    Bottom row first, each row left to right, RGB interleaved.

    As an array (``np.array(image)``) it is flat int64, so that ``+ 256`` and ``astype`` work as before; with
    ``dtype=np.uint8`` the values wrap to 0..255. New code uses `array` (uint8, no copy) or `upright()`.
    """

    __slots__ = ()

    holds_pixels: ClassVar[bool] = True
    """Tells the encoder that `tobytes` returns the bytes to send."""

    @classmethod
    def from_bytes(
        cls, data: bytes | bytearray | memoryview, width: int, height: int, channels: int = 3
    ) -> VisionImage:
        """Make an image from received unsigned bytes; `channels` is 3 (RGB) or 1 (grey). ValueError for a
        wrong size."""
        return cls._from_buffer(data, width, height, channels)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        import numpy as np

        if self._received is None:
            return _converted(np.array(list(self)), dtype, copy)
        signed = np.frombuffer(self._received, np.int8)
        if dtype is not None and np.dtype(dtype) == np.uint8:
            signed = signed.view(np.uint8)
        return _converted(signed, np.int64 if dtype is None else dtype, copy)

    def _flat(self) -> NDArray[np.uint8]:
        import numpy as np

        if self._received is None:
            return np.array(list(self)).astype(np.uint8)
        return np.frombuffer(self._received, np.uint8)

    def _encode(self) -> bytes:
        return bytes([int(value) & 0xFF for value in self])

    def _decode(self, received: memoryview) -> list[Any]:
        signed, take = _signed_ints()
        return take(received).tolist() if take else [signed[value] for value in received]


class DepthBuffer(PixelList):
    """Depth buffer that ``simxGetVisionSensorDepthBuffer`` returns: width*height floats, bottom row first.

    0 is the near clipping plane and 1 the far one, linear in the distance along the viewing axis. As an array
    it is flat float64, as for a list of Python floats; `array` is the received float32, without a copy.
    """

    __slots__ = ()

    _item_bytes = 4

    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview, width: int, height: int) -> DepthBuffer:
        """Make a depth buffer from float32 values in this machine's byte order. ValueError for a wrong size."""
        return cls._from_buffer(data, width, height, 1)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        import numpy as np

        return _converted(self._flat(), np.float64 if dtype is None else dtype, copy)

    def _flat(self) -> NDArray[np.float32]:
        import numpy as np

        if self._received is None:
            return np.array(list(self), np.float32)
        return np.frombuffer(self._received, np.float32)

    def _encode(self) -> bytes:
        return self._flat().tobytes()

    def _decode(self, received: memoryview) -> list[Any]:
        return received.cast("f").tolist()


def _converted(values: NDArray[Any], dtype: DTypeLike | None, copy: bool | None) -> NDArray[Any]:
    """Return a separate array that may be written and resized, unless ``copy=False`` requests a view."""
    target = values.dtype if dtype is None else dtype
    if copy is False and values.dtype != target:
        raise ValueError(
            f"an image cannot be seen as {target} without a copy; leave copy=False out, or use .array"
        )
    return values if copy is False else values.astype(target)


@functools.cache
def _signed_ints() -> tuple[list[int], Callable[[memoryview], NDArray[Any]] | None]:
    """Return the signed Python int of each byte, and a vectorised look-up of the same if NumPy is installed.

    Picking prepared objects is three times as fast as ``int8.tolist()``, which allocates each int below -5.
    """
    signed = [value - 256 if value > 127 else value for value in range(256)]
    try:
        import numpy as np
    except ImportError:
        return signed, None
    objects = np.array(signed, dtype=object)
    return signed, lambda received: objects.take(np.frombuffer(received, np.uint8))
