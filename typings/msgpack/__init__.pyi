"""What this project uses of msgpack, which ships no types."""

from collections.abc import Callable
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
def unpackb(packed: bytes, *, unicode_errors: str | None = None, strict_map_key: bool = True) -> Any: ...
