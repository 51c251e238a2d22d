"""viser's server after days: what it keeps for browsers that come is numbered anew, and is the same."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

import msgspec
import viser
from viser._messages import GetRenderResponseMessage, Message
from websockets.exceptions import ConnectionClosedError

from simx_server.viewer.page import quiet_viser
from simx_server.viewer.page.quiet_viser import open_browser_server, renumber

pytestmark = pytest.mark.slow

MANY = 100


@pytest.fixture
def browser(monkeypatch: pytest.MonkeyPatch) -> Iterator[viser.ViserServer]:
    monkeypatch.setattr(quiet_viser, "_MANY", MANY)
    server = open_browser_server()
    yield server
    server.stop()


def buffer_of(browser: viser.ViserServer) -> Any:
    return browser._websock_server._broadcast_buffer


def renumbered(browser: viser.ViserServer) -> int:
    """How many numbers there are then."""
    renumber(browser)
    asyncio.run_coroutine_threadsafe(asyncio.sleep(0), browser.get_event_loop()).result(20)
    return buffer_of(browser).message_counter


def moved(browser: viser.ViserServer) -> viser.FrameHandle:
    frame = browser.scene.add_frame("/moved")
    for step in range(5 * MANY):
        frame.position = np.array([step, 0.0, 0.0])
    return frame


def test_what_browsers_get_is_the_same_under_new_numbers(browser: viser.ViserServer) -> None:
    frame = moved(browser)
    buffer = buffer_of(browser)
    kept = [buffer.message_from_id[number] for number in sorted(buffer.message_from_id)]
    assert buffer.message_counter > 5 * MANY
    assert renumbered(browser) == len(kept) < MANY
    assert list(buffer.message_from_id) == list(range(len(kept)))
    assert list(buffer.message_from_id.values()) == kept
    frame.position = np.array([-1.0, 0.0, 0.0])
    assert len(buffer.message_from_id) == len(kept), "a newer place takes that of the older one"
    frame.remove()
    assert len(buffer.message_from_id) < len(kept)
    assert set(buffer.id_from_redundancy_key.values()) <= set(buffer.message_from_id)


def test_numbers_stay_while_a_browser_is_there_or_there_are_few(browser: viser.ViserServer) -> None:
    few = buffer_of(browser).message_counter
    assert renumbered(browser) == few
    moved(browser)
    buffer_of(browser).generator_cursors[1] = 5
    assert renumbered(browser) > 5 * MANY


def test_a_server_that_has_stopped_is_left_alone() -> None:
    browser = open_browser_server()
    browser.stop()
    renumber(browser)


def packed(kind: str, **fields: Any) -> bytes:
    return msgspec.msgpack.encode({"type": kind, **fields})


def test_messages_of_browsers_are_read_as_far_as_the_page_may_send_them(browser: viser.ViserServer) -> None:
    read = Message.deserialize
    image = read(packed("GetRenderResponseMessage", payload=bytes(3_000_000), render_uuid="a"))
    assert isinstance(image, GetRenderResponseMessage)
    assert len(image.payload) == 3_000_000
    start = {"source_component_uuid": "a", "transfer_uuid": "b", "filename": "c", "mime_type": "d"}
    for bad in (
        packed("GetRenderResponseMessage", payload=[[]] * 5000, render_uuid="a"),
        packed("FileTransferStartUpload", **start, part_count=9, size_bytes=9),
        packed("FileTransferPart", **start, part_index=0, content=b"a"),
        packed("NoSuchMessage"),
        b"\x91" * 4000,
        b"",
    ):
        with pytest.raises(ConnectionClosedError):
            read(bad)
