"""Set up viser's server for the web viewer: hidden behind the gate, silent, and as fast after days as at first."""

from __future__ import annotations

import contextlib
import io
import json
import logging
import secrets
import socket
import warnings

import viser
from viser import infra
from viser._messages import Message, RunJavascriptMessage
from viser.infra._async_message_buffer import AsyncMessageBuffer
from websockets.exceptions import ConnectionClosedError

from simx_server.viewer.browser_messages import REFUSED, BadMessage, check

logger = logging.getLogger(__name__)

_read = Message.deserialize

_MOST_LETTERS = 200
"""Letters of an error in the log."""

_MANY = 1_000_000
"""Numbers that viser looks up in about a tenth of a second."""


def open_browser_server() -> viser.ViserServer:
    """Return a server that only the gate should know: viser accepts everyone, also web sites in local browsers.

    These can try all ports of 127.0.0.1 in turn, but not all addresses of loopback; on systems with only one such
    address (other than Linux), only the port is hidden.
    """
    for host in (
        f"127.{'.'.join(str(each) for each in secrets.token_bytes(2))}.{1 + secrets.randbelow(254)}",
        "127.0.0.1",
    ):
        with socket.socket() as claimed, contextlib.suppress(OSError):
            # viser tries the next ports after a taken one, so a race for this port does no harm.
            claimed.bind((host, 0))
            port = int(claimed.getsockname()[1])
            break
    else:
        raise OSError("no port of this machine is free")
    # viser prints its address even when it is not verbose; stdout is for the gate's.
    Message.deserialize = staticmethod(_read_bounded)  # viser has no place for it
    # Its warnings have the whole value, and Python keeps each text.
    warnings.filterwarnings("ignore", r"\[viser\]", module=r"viser\.infra\._messages")
    with contextlib.redirect_stdout(io.StringIO()):
        return viser.ViserServer(host=host, port=port, verbose=False)


def _read_bounded(message: bytes) -> infra.Message:
    """Read a message of a browser.

    Raises:
        ConnectionClosedError: the page never sends such a message; viser closes the connection without more ado.
    """
    try:
        check(message)
        made = _read(message)
        if type(made).__name__ in REFUSED:
            raise BadMessage("a file, which the page has not asked for")
    except Exception as problem:
        logger.info(
            "a browser is cut off, which has sent something unreadable: %s", str(problem)[:_MOST_LETTERS]
        )
        raise ConnectionClosedError(None, None) from None
    return made


def set_title(browser: viser.ViserServer, title: str) -> None:
    """Set the title of the browser's tab, here and in every browser that comes later."""
    # viser has no call for it. A text in JSON is also a text in JavaScript.
    script = RunJavascriptMessage(f"document.title = {json.dumps(title)};")
    browser.gui._websock_interface.queue_message(script)  # pyright: ignore[reportPrivateUsage]


def renumber(browser: viser.ViserServer) -> None:
    """Number viser's stored messages from 0 again, if there were many and no browser is connected.

    For each new browser viser looks up every number that it ever used, and the others wait: days of motion take
    seconds.
    """
    buffer = browser._websock_server._broadcast_buffer  # pyright: ignore[reportPrivateUsage]  # no other way
    with contextlib.suppress(RuntimeError):  # it has stopped
        browser.get_event_loop().call_soon_threadsafe(_renumber, buffer)


def _renumber(buffer: AsyncMessageBuffer) -> None:
    """Number the messages again, on viser's thread, which serves browsers."""
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
