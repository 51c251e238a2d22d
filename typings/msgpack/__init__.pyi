"""What this project uses of msgpack, which ships no types."""

from collections.abc import Callable, Iterator
from typing import Any

class Packer:
    def __init__(
        self,
        *,
        default: Callable[[Any], Any] | None = None,
        use_single_float: bool = False,
        unicode_errors: str | None = None,
        buf_size: int = 262144,
    ) -> None: ...
    def pack(self, o: Any) -> bytes: ...

def packb(
    o: Any,
    *,
    default: Callable[[Any], Any] | None = None,
    use_single_float: bool = False,
    unicode_errors: str | None = None,
) -> bytes: ...
def unpackb(
    packed: bytes,
    *,
    unicode_errors: str | None = None,
    strict_map_key: bool = True,
    list_hook: Callable[[list[Any]], Any] | None = None,
    object_hook: Callable[[dict[Any, Any]], Any] | None = None,
    max_array_len: int = -1,
    max_map_len: int = -1,
) -> Any: ...

class UnpackException(Exception): ...
class OutOfData(UnpackException): ...

class Unpacker:
    def __init__(
        self,
        *,
        max_buffer_size: int = 104857600,
        unicode_errors: str | None = None,
        strict_map_key: bool = True,
    ) -> None: ...
    def __iter__(self) -> Iterator[Any]: ...
    def feed(self, next_bytes: bytes) -> None: ...
    def unpack(self) -> Any: ...
    def skip(self) -> None: ...
    def read_array_header(self) -> int: ...

class ExtType(tuple[int, bytes]):
    def __new__(cls, code: int, data: bytes) -> ExtType: ...

class Timestamp:
    def __init__(self, seconds: int, nanoseconds: int = 0) -> None: ...
