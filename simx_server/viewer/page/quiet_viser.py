"""viser's server as the page wants it: where only the gate finds it, silent, and as quick after days as at first."""

from __future__ import annotations

import contextlib
import io
import json
import secrets
import socket

import viser
from viser._messages import RunJavascriptMessage
from viser.infra._async_message_buffer import AsyncMessageBuffer

_MANY = 1_000_000
"""Numbers that viser looks up in about a tenth of a second."""


def open_browser_server() -> viser.ViserServer:
    """One that only the gate is to know: viser lets in whoever comes, web sites in this machine's browsers too.

    These can try all ports of 127.0.0.1 in turn, but not all addresses of loopback; where there is only one
    (on other systems than Linux), the port is all that is hidden.
    """
    for host in (
        f"127.{'.'.join(str(each) for each in secrets.token_bytes(2))}.{1 + secrets.randbelow(254)}",
        "127.0.0.1",
    ):
        with socket.socket() as claimed, contextlib.suppress(OSError):
            # viser tries the ports after a taken one by itself, so nothing is lost if another takes this one now.
            claimed.bind((host, 0))
            port = int(claimed.getsockname()[1])
            break
    else:
        raise OSError("no port of this machine is free")
    # It tells its own address even when it is not to be verbose; stdout is for the page's.
    with contextlib.redirect_stdout(io.StringIO()):
        return viser.ViserServer(host=host, port=port, verbose=False)


def set_title(browser: viser.ViserServer, title: str) -> None:
    """Set the title of the browser's tab, here and in every browser that comes later."""
    # viser has no call for it. In JSON every text is a text of JavaScript too.
    script = RunJavascriptMessage(f"document.title = {json.dumps(title)};")
    browser.gui._websock_interface.queue_message(script)  # pyright: ignore[reportPrivateUsage]


def renumber(browser: viser.ViserServer) -> None:
    """Have what viser keeps for browsers that come numbered from 0 again, if there were many and none is there.

    For each that comes it looks up every number it ever gave, and the others wait: days of motion are seconds.
    """
    buffer = browser._websock_server._broadcast_buffer  # pyright: ignore[reportPrivateUsage]  # no other way
    with contextlib.suppress(RuntimeError):  # it has stopped
        browser.get_event_loop().call_soon_threadsafe(_renumber, buffer)


def _renumber(buffer: AsyncMessageBuffer) -> None:
    """On viser's thread, where browsers are served."""
    with buffer.buffer_lock:
        kept = buffer.message_from_id
        if buffer.generator_cursors or buffer.message_counter < len(kept) + _MANY:
            return
        new = {number: index for index, number in enumerate(sorted(kept))}
        buffer.message_from_id = {new[number]: kept[number] for number in new}
        buffer.id_from_redundancy_key = {
            key: new[number] for key, number in buffer.id_from_redundancy_key.items()
        }
        buffer.ids_from_entity_state_key = {
            key: {new[number] for number in numbers}
            for key, numbers in buffer.ids_from_entity_state_key.items()
        }
        buffer.message_counter = len(new)
