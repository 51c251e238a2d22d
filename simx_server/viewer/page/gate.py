"""Control access to the web viewer. viser listens behind this gate, at an address that is not published.

- A viewer for this host alone (a loopback address) accepts every browser that was directed here by its user. A web site
  that the user has open elsewhere could reach it by its own host name (DNS rebinding), open a WebSocket to it, or show
  it in a frame beneath other things to click; so `Host`, `Origin` and the browser's frame headers must name this
  address.
- A viewer for others requires a token once. It is part of the address that is printed at the start; then it is a
  cookie.

Accepted connections are copied unchanged: one connection here, one there. The gate reads the head of a request only
once per connection, so connections are closed after each answer (except WebSockets, which stay).
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import logging
import secrets
import socket
import threading
from dataclasses import dataclass
from urllib.parse import SplitResult, parse_qs, parse_qsl, urlencode, urlsplit

from simx_server.browsers import Places, cookie_of, end_connection, is_of_another_page
from simx_server.service.clients.admission.unfinished import Holder, Unfinished

from .websocket_size import MessageSize

logger = logging.getLogger(__name__)

MOST_HEAD = 16_384
"""Bytes of the head of a request."""

_HEAD_TIMEOUT = 10.0
"""Time-out in seconds for the head of a request."""

_CHUNK = 65_536
_MOST_CONNECTIONS = 200
_MOST_OF_ONE = 100
"""Connections from one other machine; a browser makes seven."""

_MOST_FIELDS = 100
"""Parameters of an address."""

_MOST_FRAMES, _AT_ONCE = 1000, 1.0
"""Frames of a connection in a second, and seconds of them that may come together: each takes viser's time, however
small it is. A page that is used sends some 100 in a second.
"""

_LOOK = 1.0
"""Seconds between two looks for messages that do not go on."""


def is_loopback(host: str) -> bool:
    """Return whether only this host can reach an address."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Refused(Exception):
    """The answer that a request gets instead of the web viewer."""

    def __init__(self, status: str, text: str, *headers: str) -> None:
        super().__init__(text)
        self.status, self.text, self.headers = status, text, headers

    def response(self) -> bytes:
        body = self.text.encode()
        lines = (
            f"HTTP/1.1 {self.status}",
            "Content-Type: text/plain; charset=utf-8",
            f"Content-Length: {len(body)}",
            "Connection: close",
            "Referrer-Policy: no-referrer",
            *self.headers,
        )
        return "\r\n".join(lines).encode() + b"\r\n\r\n" + body


@dataclass(frozen=True)
class Rules:
    """Requests that pass the gate."""

    token: str | None
    """None: no token is required."""

    cookie: str
    """Name of the cookie that keeps the token."""

    def checked(self, head: bytes) -> bytes:
        """Return the head in the form that is passed on. Raises Refused."""
        lines = head.decode("latin-1").split("\r\n")
        try:
            method, target, _ = lines[0].split(" ")
        except ValueError:
            raise Refused("400 Bad Request", "That is no HTTP request.\n") from None
        headers: dict[str, str] = {}
        for line in lines[1:]:
            name, _, value = line.partition(":")
            headers[name.strip().lower()] = value.strip()
        if method not in ("GET", "HEAD"):
            raise Refused("405 Method Not Allowed", "This page is only looked at: GET.\n", "Allow: GET, HEAD")
        self._check_place(headers)
        if self.token is not None:
            self._check_token(self.token, target, headers)
        if headers.get("upgrade", "").lower() == "websocket":
            return head
        kept = [line for line in lines[:-2] if line.partition(":")[0].strip().lower() != "connection"]
        return "\r\n".join([*kept, "Connection: close"]).encode("latin-1") + b"\r\n\r\n"

    def _check_place(self, headers: dict[str, str]) -> None:
        host = headers.get("host", "")
        if self.token is None and not is_loopback(_split(f"//{host}").hostname or ""):
            raise Refused(
                "403 Forbidden",
                f"This page is this host's alone; it is no part of '{host}'. "
                "For others, start it with --view HOST:PORT.\n",
            )
        origin = headers.get("origin")
        if origin is not None and _split(origin).netloc != host:
            raise Refused("403 Forbidden", "Another web site may not use this page.\n")
        if is_of_another_page(headers, in_frames=True):
            raise Refused("403 Forbidden", "Another web site may not show this page within its own.\n")

    def _check_token(self, token: str, target: str, headers: dict[str, str]) -> None:
        shown = _parameter(target, "token")
        if shown and hmac.compare_digest(shown.encode(), token.encode()):
            # Removed from the address bar, where it could be seen or copied along with the address.
            cookie = f"{self.cookie}={token}; Path=/; HttpOnly; SameSite=Strict"
            raise Refused(
                "303 See Other", "", f"Set-Cookie: {cookie}", f"Location: {_without(target, 'token')}"
            )
        kept = cookie_of(headers.get("cookie", ""), self.cookie)
        if not hmac.compare_digest(kept.encode(), token.encode()):
            raise Refused(
                "401 Unauthorized",
                "This page asks for a token. The server printed an address with it when it started: "
                "http://HOST:PORT/?token=...\n",
            )


class Gate:
    """Accepts browsers at a listening socket, until `close`."""

    def __init__(self, listener: socket.socket, behind: tuple[str, int], token: str | None = None) -> None:
        """Make a gate, which owns the socket from now on.

        Args:
            listener: the system keeps earlier connections waiting there.
            behind: host and port of the guarded server.
            token: the token to require; None chooses one if others can reach `listener`.
        """
        host, self.port = listener.getsockname()[:2]
        self.token = token or (None if is_loopback(host) else secrets.token_urlsafe(16))
        """None: no token is required."""
        self.url = f"http://{_shown(host)}:{self.port}/"
        """The address for a browser; for other hosts, with the token."""
        if self.token is not None:
            self.url += f"?token={self.token}"
        self._rules = Rules(
            self.token, f"simx_token_{self.port}"
        )  # cookies of one host are for all its ports
        self._behind = behind
        self._places = Places()
        self._unfinished = Unfinished()
        self._loop = asyncio.new_event_loop()
        self._server = self._loop.run_until_complete(
            asyncio.start_server(self._admit, sock=listener, limit=MOST_HEAD)
        )
        self._thread = threading.Thread(target=self._run, name="simx-gate", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Cut every connection and stop listening."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)  # gather needs it
        self._look()
        try:
            self._loop.run_forever()
        finally:
            self._server.close()
            # A task that is cancelled before it has run at all cannot handle that, and asyncio reports an error.
            self._loop.run_until_complete(asyncio.sleep(0))
            tasks = asyncio.all_tasks(self._loop)
            for task in tasks:
                task.cancel()
            self._loop.run_until_complete(asyncio.gather(*tasks, return_exceptions=True))
            self._loop.close()

    def _look(self) -> None:
        self._unfinished.look()
        self._loop.call_later(_LOOK, self._look)

    async def _admit(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        most = _MOST_CONNECTIONS
        try:
            if not self._places.enter(writer, many=most, most=most, most_of_one=_MOST_OF_ONE):
                raise Refused(
                    "503 Service Unavailable", "Too many connections to this page; close some browsers.\n"
                )
            async with asyncio.timeout(_HEAD_TIMEOUT):
                head = await _head(reader)
            self._places.has_request(writer)
            await self._pass_on(self._rules.checked(head), reader, writer)
        except Refused as refusal:
            writer.write(refusal.response())
            with contextlib.suppress(OSError, TimeoutError):
                async with asyncio.timeout(_HEAD_TIMEOUT):
                    await writer.drain()
        except (OSError, TimeoutError, asyncio.IncompleteReadError):
            logger.debug("a browser went away, or did not say what it wants")
        except asyncio.CancelledError:
            logger.debug("a browser is cut off, since the page ends")  # asyncio would report it as an error
        finally:
            # A task that is cancelled, since the page ends, closes at once.
            with contextlib.suppress(asyncio.CancelledError):
                await end_connection(writer)
            self._places.leave(writer)

    # --- accepted connections --------------------------------------------------------------------

    async def _pass_on(self, head: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        back_reader, back_writer = await asyncio.open_connection(*self._behind)
        unfinished = self._unfinished.holder(lambda _why: writer.transport.abort())
        try:
            back_writer.write(head)
            ways = [
                asyncio.ensure_future(_copy(reader, back_writer, unfinished)),
                asyncio.ensure_future(_copy(back_reader, writer)),
            ]
            try:
                # The viewer's last data must arrive; a closed browser also ends the connection.
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for way in ways:
                    way.cancel()
                await asyncio.gather(*ways, return_exceptions=True)
        finally:
            unfinished.end()
            back_writer.close()


async def _head(reader: asyncio.StreamReader) -> bytes:
    """Return the head of a request. Raises Refused, IncompleteReadError."""
    try:
        return await reader.readuntil(b"\r\n\r\n")
    except asyncio.LimitOverrunError:
        raise Refused(
            "431 Request Header Fields Too Large",
            f"More than {MOST_HEAD} bytes; if these are cookies of other pages of this host, delete them.\n",
        ) from None


async def _copy(
    source: asyncio.StreamReader, sink: asyncio.StreamWriter, unfinished: Holder | None = None
) -> None:
    """Copy until the source ends; count the messages of a browser. Raises BadFrame."""
    size, now = MessageSize(), asyncio.get_running_loop().time
    served = 0.0
    """When viser has had the time for all frames so far."""

    while data := await source.read(_CHUNK):
        if unfinished is not None:
            before, frames = size.count, size.frames
            held = size.add(data)
            unfinished.hold(held, is_new=size.count > before)
            served = max(served, now()) + (size.frames - frames) / _MOST_FRAMES
        sink.write(data)
        await sink.drain()
        if (early := served - now()) > _AT_ONCE:
            await asyncio.sleep(early)


def _split(address: str) -> SplitResult:
    """Split an address. Raises Refused."""
    try:
        parts = urlsplit(address)
        _ = parts.hostname
    except ValueError:
        raise Refused("400 Bad Request", "That is no address.\n") from None
    return parts


def _parameter(target: str, name: str) -> str:
    """Return a parameter of an address, the last of its name; empty without it. Raises Refused."""
    try:
        return parse_qs(_split(target).query, max_num_fields=_MOST_FIELDS).get(name, [""])[-1]
    except ValueError:
        raise Refused("400 Bad Request", f"At most {_MOST_FIELDS} parameters.\n") from None


def _without(target: str, name: str) -> str:
    """Return the page with the parameters of an address, such as its view, except those of a name."""
    kept = [(key, value) for key, value in parse_qsl(_split(target).query) if key != name]
    return f"/?{urlencode(kept, safe=',')}" if kept else "/"


def _shown(host: str) -> str:
    """Return a host in the form that an address needs."""
    if ipaddress.ip_address(host).is_unspecified:
        return "localhost"
    return f"[{host}]" if ":" in host else host
