"""The page's HTTP server: forms that no browser sends, slow and silent peers, and too many of them."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Awaitable, Callable
from http import HTTPStatus

import pytest

from simx_server.classroom.page import http
from simx_server.classroom.page.http import BadRequest, HttpServer, Request, Response, read_head

GOOD = b"GET /class?x=1 HTTP/1.1\r\nHost: here\r\nCookie: a=1; b=2\r\n\r\n"


async def echo(request: Request) -> Response:
    if request.path == "/fault":
        raise RuntimeError("of the page")
    return Response(HTTPStatus.OK, request.path.encode())


def serving(work: Callable[[tuple[str, int]], Awaitable[None]]) -> None:
    """Do something with a server at an address."""

    async def run() -> None:
        listener = socket.create_server(("127.0.0.1", 0))
        async with asyncio.timeout(60), await HttpServer(echo).listen(listener):
            await work(listener.getsockname())

    asyncio.run(run())


async def answer(place: tuple[str, int], request: bytes) -> bytes:
    """All that comes until the server closes the connection."""
    reader, writer = await asyncio.open_connection(*place)
    writer.write(request)
    try:
        return await reader.read()
    except ConnectionResetError:
        return b""
    finally:
        writer.close()


def closing(request: bytes) -> bytes:
    return request.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n")


def test_head_is_read() -> None:
    request = read_head(GOOD)
    assert (request.method, request.path, request.query) == ("GET", "/class", {"x": "1"})
    assert request.cookie("b") == "2"
    assert request.cookie("c") == ""


@pytest.mark.parametrize(
    "head",
    [
        b"\r\n\r\n",
        b"GET /\r\n\r\n",
        b"GET http://elsewhere/ HTTP/1.1\r\n\r\n",
        b"GET / HTTP/2\r\n\r\n",
        b"GET / HTTP/1.1\r\nno colon\r\n\r\n",
        b"GET / HTTP/1.1\r\nname : value\r\n\r\n",
        b"GET / HTTP/1.1\r\n folded: line\r\n\r\n",
        b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n",
        b"GET //[ HTTP/1.1\r\n\r\n",
        b"GET /?" + b"a=1&" * 100 + b" HTTP/1.1\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n",
    ],
)
def test_head_of_another_form_is_refused(head: bytes) -> None:
    with pytest.raises(BadRequest):
        read_head(head)


@pytest.mark.parametrize(
    ("request_bytes", "status"),
    [
        (closing(GOOD), b"200"),
        (b"GET /fault HTTP/1.0\r\n\r\n", b"500"),
        (b"nonsense\r\n\r\n", b"400"),
        (b"GET / HTTP/1.1\r\n" + b"x: y\r\n" * 5000, b"431"),
        (b"POST / HTTP/1.1\r\nContent-Length: 5000\r\n\r\n", b"413"),
        (b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", b"400"),
        (b"POST / HTTP/1.0\r\nContent-Length: 3\r\n\r\nabc", b"200"),
    ],
)
def test_each_request_gets_its_status(request_bytes: bytes, status: bytes) -> None:
    async def work(place: tuple[str, int]) -> None:
        said = await answer(place, request_bytes)
        assert said.split(b" ")[1] == status
        assert (await answer(place, closing(GOOD))).endswith(b"/class")  # the page goes on

    serving(work)


def test_connection_stays_for_further_requests() -> None:
    async def work(place: tuple[str, int]) -> None:
        said = await answer(place, GOOD + GOOD + closing(GOOD))
        assert said.count(b"HTTP/1.1 200 OK") == 3

    serving(work)


def test_silent_and_slow_peers_are_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "IDLE", 0.05)
    monkeypatch.setattr(http, "SLOW", 0.05)

    async def work(place: tuple[str, int]) -> None:
        assert await answer(place, b"") == b""
        assert await answer(place, b"GET / HTT") == b""
        assert await answer(place, b"POST / HTTP/1.1\r\nContent-Length: 10\r\n\r\nab") == b""

    serving(work)


def test_silent_peers_do_not_keep_others_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "MOST_CONNECTIONS", 5)

    async def work(place: tuple[str, int]) -> None:
        silent = [await asyncio.open_connection(*place) for _ in range(20)]
        assert (await answer(place, closing(GOOD))).endswith(b"/class")
        for reader, _ in silent[:10]:  # those that waited longest are closed
            with pytest.raises((ConnectionResetError, EOFError)):
                await reader.readexactly(1)
        for _, writer in silent:
            writer.close()

    serving(work)
