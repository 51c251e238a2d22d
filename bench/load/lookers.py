"""What a browser is to the page, without its drawing: a WebSocket that says where it looks from, and listens.

Needs the extra viewer, so its packages are imported when somebody looks.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from typing import Any

_CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (2.0, 2.0, 1.0), "fov": 1.0,
    "near": 0.01, "far": 100.0, "image_height": 600, "image_width": 800, "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip
"""A browser counts as there once it has sent this."""

_READY_WITHIN_S = 30.0
_MOST_BYTES = 100_000_000


def messages(window: bytes) -> list[dict[str, Any]]:
    """What stands in a message of viser's, but for its arrays: sizes, then msgpack compressed by zstd."""
    import msgspec
    import zstandard

    whole, packed = (int.from_bytes(window[at : at + 8], "little") for at in (0, 8))
    content = zstandard.ZstdDecompressor().decompress(window[16 : 16 + packed], max_output_size=whole)
    return list(msgspec.msgpack.decode(content)["messages"])


@contextmanager
def looking(url: str, count: int, on_message: Callable[[int, bytes], object]) -> Iterator[None]:
    """So many look at a page within the block, all from one thread.

    Args:
        url: of the page, beginning with http.
        on_message: called on that thread with a looker's number and what came.
    """
    import msgspec
    import viser
    from websockets.asyncio.client import connect
    from websockets.typing import Subprotocol

    ready: Future[None] = Future()
    loop = asyncio.new_event_loop()

    async def look(number: int, first: asyncio.Future[None]) -> None:
        async with connect(
            "ws" + url.removeprefix("http"),
            subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
            max_size=_MOST_BYTES,
            compression=None,
        ) as connection:
            await connection.send(msgspec.msgpack.encode(_CAMERA))
            async for message in connection:
                assert isinstance(message, bytes)
                on_message(number, message)
                if not first.done():
                    first.set_result(None)

    async def look_all() -> None:
        firsts = [loop.create_future() for _ in range(count)]
        try:
            async with asyncio.TaskGroup() as lookers:
                for number, first in enumerate(firsts):
                    lookers.create_task(look(number, first))
                await asyncio.gather(*firsts)
                ready.set_result(None)
        except Exception as error:
            if ready.done():
                raise
            ready.set_exception(error)

    task = loop.create_task(look_all())

    def run() -> None:
        asyncio.set_event_loop(loop)
        with contextlib.suppress(asyncio.CancelledError):
            loop.run_until_complete(task)
        loop.close()

    thread = threading.Thread(target=run, name="lookers", daemon=True)
    thread.start()
    try:
        ready.result(_READY_WITHIN_S)
        yield
    finally:
        if thread.is_alive():
            loop.call_soon_threadsafe(task.cancel)
        thread.join()
