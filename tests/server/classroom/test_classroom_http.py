"""The page's HTTP server: forms that no browser sends, slow and silent peers, and too many of them."""

from __future__ import annotations

import asyncio
import os
import socket
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import ExitStack, asynccontextmanager, suppress
from http import HTTPStatus

import pytest

from simx_server import browsers
from simx_server.classroom.page import http
from simx_server.classroom.page.http import BadRequest, HttpServer, Request, Response, read_head

pytestmark = pytest.mark.slow

GOOD = b"GET /class?x=1 HTTP/1.1\r\nHost: here\r\nCookie: a=1; b=2\r\n\r\n"


async def echo(request: Request) -> Response:
    if request.path == "/fault":
        raise RuntimeError("of the page")
    if request.path == "/large":
        return Response(HTTPStatus.OK, bytes(10_000_000))
    return Response(HTTPStatus.OK, request.path.encode())


def serving(
    work: Callable[[tuple[str, int]], Awaitable[None]],
    handle: Callable[[Request], Awaitable[Response]] = echo,
) -> None:
    """Do something with a server at an address; then wait until it has no connection any more."""

    async def run() -> None:
        listener = socket.create_server(("127.0.0.1", 0))
        server = HttpServer(handle)
        async with asyncio.timeout(60), await server.listen(listener):
            await work(listener.getsockname())
            while len(server._places):
                await asyncio.sleep(0)
            await asyncio.sleep(0)  # transports close in the next turn

    asyncio.run(run())


Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


@asynccontextmanager
async def connections(place: tuple[str, int], count: int) -> AsyncIterator[list[Streams]]:
    """Open this many connections, one after the other."""
    opened = [await asyncio.open_connection(*place) for _ in range(count)]
    try:
        yield opened
    finally:
        for _, writer in opened:
            writer.close()
            with suppress(ConnectionError):
                await writer.wait_closed()


async def answer(place: tuple[str, int], request: bytes) -> bytes:
    """All that comes until the server closes the connection."""
    async with connections(place, 1) as [(reader, writer)]:
        writer.write(request)
        with suppress(ConnectionResetError):
            return await reader.read()
        return b""


def closing(request: bytes) -> bytes:
    return request.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n")


def test_head_is_read() -> None:
    request = read_head(GOOD)
    assert (request.method, request.path, request.query) == ("GET", "/class", {"x": "1"})
    assert request.cookie("b") == "2"
    assert request.cookie("c") == ""


@pytest.mark.parametrize("other", ['layout={"a": "b c"}', "_xsrf=2|1:0; flag", 'a="b', "=x", "é=ü"])
def test_cookies_of_other_programs_of_the_host_hide_none_of_the_page(other: str) -> None:
    for cookies in (f"{other}; own=token", f"own=token; {other}", f"{other};own=token;{other}"):
        head = f"GET / HTTP/1.1\r\nCookie: {cookies}\r\n\r\n"
        assert read_head(head.encode("latin-1")).cookie("own") == "token"


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


def test_many_requests_in_one_connection_keep_no_other_waiting() -> None:
    served: list[str] = []
    others: list[asyncio.StreamWriter] = []

    async def handle(request: Request) -> Response:
        served.append(request.path)
        if others:  # with the first of many requests, which are here already
            others.pop().write(GOOD)
        return await echo(request)

    async def work(place: tuple[str, int]) -> None:
        async with connections(place, 2) as [(_, flood), (reader, other)]:
            others.append(other)
            flood.write(b"GET /a HTTP/1.1\r\n\r\n" * 500)
            await reader.readuntil(b"/class")
            assert served.index("/class") < 100

    serving(work, handle)


def test_silent_and_slow_peers_are_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "IDLE", 0.05)
    monkeypatch.setattr(http, "SLOW", 0.05)

    async def work(place: tuple[str, int]) -> None:
        assert await answer(place, b"") == b""
        assert await answer(place, b"GET / HTT") == b""
        assert await answer(place, b"POST / HTTP/1.1\r\nContent-Length: 10\r\n\r\nab") == b""

    serving(work)


@pytest.mark.skipif(sys.platform != "linux", reason="counts open files in /proc")
def test_peer_that_takes_no_answer_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "SLOW", 0.05)
    monkeypatch.setattr(http, "SLOWEST", 1e9)
    monkeypatch.setattr(browsers, "SLOW", 0.05)

    async def work(place: tuple[str, int]) -> None:
        before = len(os.listdir("/proc/self/fd"))
        with socket.create_connection(place) as peer:
            peer.sendall(b"GET /large HTTP/1.1\r\n\r\n")
            while len(os.listdir("/proc/self/fd")) < before + 2:  # both ends are here
                await asyncio.sleep(0)
            while len(os.listdir("/proc/self/fd")) > before + 1:
                await asyncio.sleep(0)

    serving(work)


def test_connections_beyond_twice_the_number_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "MOST_CONNECTIONS", 3)
    held: list[Request] = []

    async def work(_: tuple[str, int]) -> None:
        may_end = asyncio.Event()

        async def hold(request: Request) -> Response:
            held.append(request)
            await may_end.wait()
            return Response(HTTPStatus.OK)

        listener = socket.create_server(("127.0.0.1", 0))
        async with await HttpServer(hold).listen(listener):
            place, waiting = listener.getsockname(), []
            for number in range(6):
                waiting.append(asyncio.create_task(answer(place, closing(GOOD))))
                while len(held) <= number:
                    await asyncio.sleep(0)
            assert b"503" in await answer(place, b"")
            may_end.set()
            assert all(b"200" in said for said in await asyncio.gather(*waiting))

    serving(work)


def test_other_machine_may_not_have_very_many_connections(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "MOST_OF_ONE", 2)
    monkeypatch.setattr(browsers, "is_this_machine", lambda address: False)

    async def work(place: tuple[str, int]) -> None:
        async with connections(place, 3) as [(oldest, _), *_]:
            with pytest.raises((ConnectionResetError, EOFError)):
                await oldest.readexactly(1)
            assert b"200 OK" in await answer(place, closing(GOOD))

    serving(work)


def test_half_sent_requests_keep_nobody_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "MOST_CONNECTIONS", 5)

    async def work(place: tuple[str, int]) -> None:
        with ExitStack() as stack:
            for _ in range(30):
                peer = stack.enter_context(socket.create_connection(place, 20))
                peer.sendall(b"POST / HTTP/1.1\r\nContent-Length: 9\r\n\r\n")
                for _ in range(10):  # until the server waits for the nine bytes
                    await asyncio.sleep(0)
            for _ in range(3):
                assert (await answer(place, closing(GOOD))).endswith(b"/class")

    serving(work)


def test_silent_peers_do_not_keep_others_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http, "MOST_CONNECTIONS", 5)

    async def work(place: tuple[str, int]) -> None:
        async with connections(place, 20) as silent:
            assert (await answer(place, closing(GOOD))).endswith(b"/class")
            for reader, _ in silent[:10]:  # those that waited longest are closed
                with pytest.raises((ConnectionResetError, EOFError)):
                    await reader.readexactly(1)

    serving(work)
