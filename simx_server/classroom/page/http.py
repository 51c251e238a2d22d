"""A small HTTP/1.1 server on asyncio for one page: bounded heads, bodies, times and connections, and no files.

The standard library's ``http.server`` has a thread for each connection and no bounds; a hostile browser would hold as
many threads as it likes. Here all connections share one thread, and when there are too many, those that wait longest
without a request are closed.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import socket
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from simx_server.browsers import SLOW, Places, cookie_of, end_connection

logger = logging.getLogger(__name__)

MOST_HEAD = 16_384
MOST_BODY = 4096
"""Bytes of a request's head, and of a body that its path does not need."""

SLOWEST = 20_000
"""Bytes a second that a browser takes of a long answer, at least."""

IDLE = 30.0
"""Seconds until a connection without a request is closed."""

MOST_CONNECTIONS = 400
"""Connections above which those without a request are closed; twice as many are the most."""

MOST_OF_ONE = 100
"""Connections from one other machine; a browser makes six."""

POLICY = "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"

SAFE: Mapping[str, str] = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Headers of every answer that does not replace them: other sites cannot frame the page, and an address with a token
stays here.
"""


@dataclass(frozen=True)
class Request:
    """A request whose form was checked."""

    method: str
    path: str
    query: Mapping[str, str]
    headers: Mapping[str, str]
    """Names in lower case."""

    body: bytes = b""

    def cookie(self, name: str) -> str:
        """Return a cookie's value; empty without it."""
        return cookie_of(self.headers.get("cookie", ""), name)


@dataclass(frozen=True)
class Response:
    """An answer."""

    status: HTTPStatus
    body: bytes = b""
    kind: str = "text/plain; charset=utf-8"
    headers: tuple[tuple[str, str], ...] = field(default=())

    def packed(self, *, is_head: bool, stays: bool) -> bytes:
        """Return the answer as bytes, without its body for a HEAD."""
        lines = [
            f"HTTP/1.1 {self.status.value} {self.status.phrase}",
            f"Content-Type: {self.kind}",
            f"Content-Length: {len(self.body)}",
            f"Connection: {'keep-alive' if stays else 'close'}",
            *(f"{name}: {value}" for name, value in {**SAFE, **dict(self.headers)}.items()),
        ]
        return "\r\n".join(lines).encode("latin-1") + b"\r\n\r\n" + (b"" if is_head else self.body)


class BadRequest(Exception):
    """A request that has no answer but this one; the connection is closed."""

    def __init__(self, status: HTTPStatus, text: str) -> None:
        super().__init__(text)
        self.response = Response(status, text.encode())


Handle = Callable[[Request], Awaitable[Response]]
MostBody = Callable[[Request], int]


class HttpServer:
    """Answers requests at a listening socket with a function."""

    def __init__(self, handle: Handle, most_body: MostBody = lambda _request: MOST_BODY) -> None:
        """Listen to nothing yet.

        Args:
            handle: makes the answer. An exception in it becomes a 500 and a line in the log.
            most_body: returns the bytes of body that a request may have, from its head.
        """
        self._handle, self._most_body = handle, most_body
        self._places = Places()

    async def listen(self, listener: socket.socket) -> asyncio.Server:
        """Start to accept connections."""
        return await asyncio.start_server(
            self._serve, sock=listener, limit=MOST_HEAD, backlog=MOST_CONNECTIONS
        )

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        most = 2 * MOST_CONNECTIONS
        try:
            if not self._places.enter(writer, many=MOST_CONNECTIONS, most=most, most_of_one=MOST_OF_ONE):
                raise BadRequest(
                    HTTPStatus.SERVICE_UNAVAILABLE, "There are too many connections to this page.\n"
                )
            while await self._serve_one(reader, writer):
                # Requests that are here already would keep the other connections waiting.
                await asyncio.sleep(0)
        except BadRequest as bad:
            writer.write(bad.response.packed(is_head=False, stays=False))
        except (OSError, TimeoutError, EOFError):
            logger.debug("a browser went away, or did not send a whole request in time")
        finally:
            try:
                await end_connection(writer)
            finally:
                self._places.leave(writer)

    async def _serve_one(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> bool:
        """Answer one request. Returns whether the connection stays for another."""
        self._places.waits(writer)
        try:
            async with asyncio.timeout(IDLE):
                head = await reader.readuntil(b"\r\n\r\n")
        except asyncio.LimitOverrunError:
            raise BadRequest(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "The head is too large.\n") from None
        request = read_head(head)
        if length := _length(request, self._most_body):
            async with asyncio.timeout(SLOW):
                request = replace(request, body=await reader.readexactly(length))
        self._places.has_request(writer)
        try:
            response = await self._handle(request)
        except Exception:
            logger.exception("a request could not be dealt with; the page goes on")
            response = Response(
                HTTPStatus.INTERNAL_SERVER_ERROR, b"The page has a fault; its log has the details.\n"
            )
        stays = (
            request.headers.get("connection", "").lower() != "close" and len(self._places) <= MOST_CONNECTIONS
        )
        self._places.waits(writer)  # also one that does not take its answer
        writer.write(response.packed(is_head=request.method == "HEAD", stays=stays))
        async with asyncio.timeout(SLOW + len(response.body) / SLOWEST):
            await writer.drain()
        return stays


def read_head(head: bytes) -> Request:
    """Return the request in the bytes of its head.

    Raises:
        BadRequest: it is not HTTP/1.1, or has a form that no browser sends.
    """
    lines = head[:-4].decode("latin-1").split("\r\n")
    words = lines[0].split(" ")
    if len(words) != 3 or words[2] not in ("HTTP/1.1", "HTTP/1.0") or not words[1].startswith("/"):
        raise BadRequest(HTTPStatus.BAD_REQUEST, "That is not an HTTP request.\n")
    headers: dict[str, str] = {}
    for line in lines[1:]:
        name, colon, value = line.partition(":")
        if not colon or name != name.strip() or not name:
            raise BadRequest(HTTPStatus.BAD_REQUEST, "That is not a header of HTTP.\n")
        headers[name.lower()] = value.strip()
    if "transfer-encoding" in headers:
        raise BadRequest(HTTPStatus.NOT_IMPLEMENTED, "No request here has a body in parts.\n")
    if words[2] == "HTTP/1.0":
        headers["connection"] = "close"
    with contextlib.suppress(ValueError):
        target = urlsplit(words[1])
        query = {name: values[-1] for name, values in parse_qs(target.query, max_num_fields=10).items()}
        return Request(words[0], target.path, query, headers)
    raise BadRequest(HTTPStatus.BAD_REQUEST, "That is not an address.\n")


def _length(request: Request, most_body: MostBody) -> int:
    text = request.headers.get("content-length", "0")
    if not (text.isascii() and text.isdecimal() and len(text) < 10):
        raise BadRequest(HTTPStatus.BAD_REQUEST, "That is not a length.\n")
    if int(text) > MOST_BODY and int(text) > most_body(request):
        raise BadRequest(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "No request here needs such a body.\n")
    return int(text)
