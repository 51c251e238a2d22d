"""The gate of the page: whom it lets in, and that nothing that comes there makes it fall."""

from __future__ import annotations

import asyncio
import re
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from typing import cast

import pytest
from processes import wait_until

from simx_server.limits import Limits
from simx_server.service.clients.admission.unfinished import Unfinished
from simx_server.viewer.launching import listen, missing
from simx_server.viewer.page import gate as gate_module
from simx_server.viewer.page.gate import Gate, is_loopback
from simx_server.viewer.page.websocket_size import LARGEST_MESSAGE, BadFrame, MessageSize

pytestmark = pytest.mark.slow

TOKEN = "a-token-of-the-test"
OTHERS = "10.1.2.3"
UPGRADE = (
    "Upgrade: websocket",
    "Connection: Upgrade",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
)
PAGE = b"the page"


class Behind:
    """Stands where viser does: answers a page, and after an upgrade sends back what comes."""

    def __init__(self) -> None:
        self.heads: list[bytes] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.place: tuple[str, int] = self._listener.getsockname()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def close(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._listener.close()

    def _serve(self) -> None:
        with ExitStack() as stack:
            while True:
                try:
                    connection = self._listener.accept()[0]
                except OSError:
                    return
                stack.callback(threading.Thread.join, answering := threading.Thread(
                    target=self._answer, args=(connection,)
                ))  # fmt: skip
                answering.start()

    def _answer(self, connection: socket.socket) -> None:
        with connection, suppress(ConnectionError):  # the gate cuts some off
            head = b""
            while not head.endswith(b"\r\n\r\n"):
                if not (data := connection.recv(4096)):
                    return
                head += data
            self.heads.append(head)
            if b"websocket" not in head:
                connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n%s" % (len(PAGE), PAGE))
                return
            connection.sendall(b"HTTP/1.1 101 Switching Protocols\r\n\r\n")
            while data := connection.recv(4096):
                connection.sendall(data)


@pytest.fixture
def behind() -> Iterator[Behind]:
    each = Behind()
    yield each
    each.close()


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    """Ended before what is behind the gate."""
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def gate(behind: Behind, closing: ExitStack) -> Gate:
    """Of this host alone."""
    made = Gate(listen("127.0.0.1:0", "--view"), behind.place)
    closing.callback(made.close)
    return made


@pytest.fixture
def open_gate(behind: Behind, closing: ExitStack) -> Gate:
    """Of others, too."""
    made = Gate(listen("0.0.0.0:0", "--view"), behind.place, TOKEN)
    closing.callback(made.close)
    return made


def connect(gate: Gate) -> socket.socket:
    return socket.create_connection(("127.0.0.1", gate.port), timeout=10)


def all_of(connection: socket.socket) -> bytes:
    """The bytes until the other side closes, or cuts the connection."""
    got = b""
    try:
        while data := connection.recv(65536):
            got += data
    except ConnectionResetError:
        pass
    return got


def ask(gate: Gate, *headers: str, target: str = "/", method: str = "GET", host: str | None = None) -> bytes:
    """The whole answer."""
    lines = (f"{method} {target} HTTP/1.1", f"Host: {host or f'localhost:{gate.port}'}", *headers, "", "")
    with connect(gate) as connection:
        connection.sendall("\r\n".join(lines).encode("latin-1"))
        if "websocket" in " ".join(headers):
            connection.shutdown(socket.SHUT_WR)
        return all_of(connection)


def status(answer: bytes) -> int:
    found = re.match(rb"HTTP/1.1 (\d+) ", answer)
    assert found, answer
    return int(found[1])


def cookie(gate: Gate, token: str = TOKEN) -> str:
    """Return the header with the cookie beside those of other programs of the host, one of which is JSON."""
    return f'Cookie: other=1; settings={{"a": [1, 2]}}; simx_token_{gate.port}={token}'


def upgraded(gate: Gate, *headers: str) -> bool:
    """Whether a WebSocket goes through, both ways."""
    lines = ("GET / HTTP/1.1", f"Host: localhost:{gate.port}", *UPGRADE, *headers, "", "")
    with connect(gate) as connection:
        connection.sendall("\r\n".join(lines).encode())
        got = connection.recv(4096)
        if status(got) != 101:
            return False
        connection.sendall(b"\x82\x0ethere and back")
        return connection.recv(4096) == b"\x82\x0ethere and back"


# --- who gets in ---------------------------------------------------------------------------------


def test_a_page_of_this_host_asks_for_no_token(gate: Gate) -> None:
    assert gate.token is None
    assert gate.url == f"http://127.0.0.1:{gate.port}/"
    assert ask(gate).endswith(PAGE)
    assert upgraded(gate, f"Origin: http://localhost:{gate.port}")


def test_a_page_for_others_has_a_token_in_its_address(behind: Behind, closing: ExitStack) -> None:
    tokens = set[str]()
    for _ in range(2):
        made = Gate(listen("0.0.0.0:0", "--view"), behind.place)
        closing.callback(made.close)
        assert made.token is not None
        assert len(made.token) >= 20
        assert made.url == f"http://localhost:{made.port}/?token={made.token}"
        tokens.add(made.token)
    assert len(tokens) == 2


@pytest.mark.parametrize(
    ("host", "is_own"),
    [("127.0.0.1", True), ("127.1.2.3", True), ("::1", True), ("localhost", True), ("0.0.0.0", False),
     ("::", False), (OTHERS, False), ("localhost.example.org", False), ("", False)],
)  # fmt: skip
def test_what_only_this_host_reaches(host: str, is_own: bool) -> None:
    assert is_loopback(host) is is_own


def test_without_the_token_neither_page_nor_websocket(open_gate: Gate, behind: Behind) -> None:
    for headers in ((), ("Cookie: simx_token_1=x",), (cookie(open_gate, "wrong"),), ('Cookie: a="b; =;;',)):
        answer = ask(open_gate, *headers)
        assert status(answer) == 401
        assert b"token" in answer
        assert PAGE not in answer
        assert status(ask(open_gate, *UPGRADE, *headers)) == 401
    for target in ("/?token=wrong", "/?token=", "/?token=%ff", f"/?nottoken={TOKEN}", "/assets/a.js"):
        assert status(ask(open_gate, target=target)) == 401
    assert behind.heads == []


def test_the_token_becomes_a_cookie_that_opens_page_and_websocket(open_gate: Gate) -> None:
    answer = ask(open_gate, target=f"/?token={TOKEN}", host=f"{OTHERS}:{open_gate.port}")
    assert status(answer) == 303
    assert b"\r\nLocation: /\r\n" in answer
    with_view = ask(
        open_gate, target=f"/?at=1,2,3&token={TOKEN}&object=a%2523b", host=f"{OTHERS}:{open_gate.port}"
    )
    assert b"\r\nLocation: /?at=1,2,3&object=a%2523b\r\n" in with_view, "the view of a link is kept"
    given = re.search(rb"Set-Cookie: (\S+=\S+); Path=/; HttpOnly; SameSite=Strict\r\n", answer)
    assert given
    assert ask(open_gate, f"Cookie: {given[1].decode()}", host=f"{OTHERS}:{open_gate.port}").endswith(PAGE)
    assert upgraded(open_gate, f"Cookie: {given[1].decode()}")
    assert ask(open_gate, cookie(open_gate), host=f"{OTHERS}:{open_gate.port}").endswith(PAGE)


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "evil.example:8080",
        "127.0.0.1.evil.example",
        OTHERS,
        "[::2]",
        "localhost@evil.example",
    ],
)
def test_a_name_of_another_site_that_leads_here_shows_nothing(gate: Gate, behind: Behind, host: str) -> None:
    answer = ask(gate, host=host)
    assert status(answer) == 403
    assert b"--view HOST:PORT" in answer
    assert status(ask(gate, *UPGRADE, host=host)) == 403
    assert behind.heads == []


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "[::1]", "LOCALHOST"])
def test_names_of_this_host_are_let_in(gate: Gate, host: str) -> None:
    assert ask(gate, host=f"{host}:{gate.port}").endswith(PAGE)


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://localhost:1", "https://localhost"])
def test_another_sites_websocket_is_refused(gate: Gate, open_gate: Gate, behind: Behind, origin: str) -> None:
    assert status(ask(gate, *UPGRADE, f"Origin: {origin}")) == 403
    assert status(ask(open_gate, *UPGRADE, f"Origin: {origin}", cookie(open_gate))) == 403
    assert behind.heads == []


def test_another_site_may_link_here_but_not_show_it_in_a_frame(gate: Gate) -> None:
    for what in ("iframe", "script", "empty", "object"):
        assert status(ask(gate, "Sec-Fetch-Site: cross-site", f"Sec-Fetch-Dest: {what}")) == 403
    assert ask(gate, "Sec-Fetch-Site: cross-site", "Sec-Fetch-Dest: document").endswith(PAGE)
    assert ask(gate, "Sec-Fetch-Site: same-site", "Sec-Fetch-Dest: iframe").endswith(PAGE)  # a notebook
    assert ask(gate, "Sec-Fetch-Site: same-origin", "Sec-Fetch-Dest: script").endswith(PAGE)


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_page_of_another_port_of_this_host_uses_nothing_either(gate: Gate, site: str) -> None:
    for what in ("script", "image", "empty", "object"):
        assert status(ask(gate, f"Sec-Fetch-Site: {site}", f"Sec-Fetch-Dest: {what}")) == 403
    for fetched in (("websocket", "websocket"), ("no-cors", "document")):
        mode, place = fetched
        told = (f"Sec-Fetch-Site: {site}", f"Sec-Fetch-Mode: {mode}", f"Sec-Fetch-Dest: {place}")
        assert status(ask(gate, *UPGRADE, *told)) == 403


def test_a_second_request_of_a_connection_is_not_smuggled_in(gate: Gate, behind: Behind) -> None:
    ask(gate, "Connection: keep-alive")
    (head,) = behind.heads
    assert head.lower().count(b"connection:") == 1
    assert b"Connection: close\r\n" in head


@pytest.mark.parametrize("method", ["POST", "PUT", "CONNECT", "OPTIONS"])
def test_it_is_only_looked_at(gate: Gate, method: str) -> None:
    answer = ask(gate, method=method)
    assert status(answer) == 405
    assert b"Allow: GET" in answer


# --- what comes there ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sent", "expected"),
    [
        (b"hello\r\n\r\n", 400),
        (b"\r\n\r\n", 400),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(range(256)) + b"\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost: [\r\n\r\n", 400),
        (b"GET / HTTP/1.1\r\nHost: localhost\r\nOrigin: http://[\r\n\r\n", 400),
        (b"GET http://[ HTTP/1.1\r\nHost: localhost\r\nCookie: \xff\r\n\r\n", 200),
        (b"GET / HTTP/1.1\r\n\r\n", 403),
        (b"GET / HTTP/1.1\r\nHost: localhost\r\nX: " + b"x" * 40_000 + b"\r\n\r\n", 431),
        (b"x" * 200_000, 431),
    ],
)
def test_whatever_is_sent_is_answered_and_the_next_browser_sees_the_page(
    gate: Gate, sent: bytes, expected: int
) -> None:
    with connect(gate) as connection:
        connection.sendall(sent)
        assert status(all_of(connection)) == expected
    assert ask(gate).endswith(PAGE)


def test_those_who_say_nothing_are_not_waited_for(gate: Gate, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gate_module, "_HEAD_TIMEOUT", 0.05)
    with connect(gate) as silent, connect(gate) as slow:
        slow.sendall(b"GET / HTTP/1.1\r\n")
        assert all_of(silent) == all_of(slow) == b""
    assert ask(gate).endswith(PAGE)


def test_half_closed_and_cut_connections_leave_nothing_behind(gate: Gate) -> None:
    before = threading.active_count()
    for sent in (b"", b"GET / HT", b"GET / HTTP/1.1\r\nHost: localhost\r\n"):
        with connect(gate) as connection:
            connection.sendall(sent)
            connection.shutdown(socket.SHUT_WR)
            assert all_of(connection) == b""
        with connect(gate) as connection:
            connection.sendall(sent)
    assert wait_until(lambda: not len(gate._places), 5)
    assert ask(gate).endswith(PAGE)
    assert threading.active_count() <= before + 1


def test_too_many_connections_are_told_so_and_room_is_used_again(
    gate: Gate, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate_module, "_MOST_CONNECTIONS", 5)
    with ExitStack() as stack:
        silent = [stack.enter_context(connect(gate)) for _ in range(5)]
        assert wait_until(lambda: len(gate._places) == 5, 5)
        browsers = [stack.enter_context(websocket(gate)) for _ in range(5)]
        assert [all_of(each) for each in silent] == [b""] * 5, "who has no request gives way"
        with connect(gate) as eleventh:
            answer = all_of(eleventh)
        assert status(answer) == 503
        assert b"close some" in answer
        browsers[0].sendall(b"\x82\x05still")
        assert browsers[0].recv(7) == b"\x82\x05still"
    assert wait_until(lambda: not len(gate._places), 5)
    assert ask(gate).endswith(PAGE)


def websocket(gate: Gate) -> socket.socket:
    lines = ("GET / HTTP/1.1", "Host: localhost", *UPGRADE, "", "")
    opened = connect(gate)
    opened.sendall("\r\n".join(lines).encode())
    assert status(opened.recv(4096)) == 101
    return opened


def test_unfinished_messages_of_browsers_are_bounded_together(gate: Gate) -> None:
    gate._unfinished = Unfinished(lambda: Limits(unfinished=150_000))
    part = b"\x82\xff" + (1 << 20).to_bytes(8, "big") + bytes(90_000)  # of a message of a megabyte
    with websocket(gate) as first, websocket(gate) as second, websocket(gate) as third:
        for each in (first, second):
            each.sendall(part)
            assert wait_until(lambda: gate._unfinished.size > 89_000, 20)
        all_of(first)  # it is cut
        third.sendall(b"\x82\xff" + (1 << 40).to_bytes(8, "big") + b"mask")
        assert all_of(third) == b""
        assert 89_000 < gate._unfinished.size < 91_000
        second.sendall(b"goes on")
        assert wait_until(lambda: b"goes on" in second.recv(1 << 17), 20)


def test_the_size_of_an_unfinished_message_is_followed_byte_by_byte() -> None:
    frames = (
        b"\x02\x05first" + b"\x89\x02hi" + b"\x80\x7e\x01\x00" + bytes(256),  # a ping within a message
        b"\x82\x83maskabc",
        b"\x82\x7f" + (70_000).to_bytes(8, "big") + bytes(70_000),
    )
    for together in (1, 7, 1 << 20):
        data, size, sizes = b"".join(frames), MessageSize(), [0]
        for at in range(0, len(data), together):
            sizes.append(size.add(data[at : at + together]))
        assert (sizes[-1], size.count) == (0, 3)
        assert max(sizes) >= 69_990 or together > 1000
    with pytest.raises(BadFrame):
        MessageSize().add(
            b"\x02\x7f" + LARGEST_MESSAGE.to_bytes(8, "big") + bytes(LARGEST_MESSAGE) + b"\x00\x01"
        )


@pytest.mark.parametrize("frame", [b"\x81\x01a", b"\xc2\x01a", b"\x83\x00", b"\x89\x7e\x00\x7e"])
def test_frames_that_no_browser_sends_to_viser_end_the_connection(gate: Gate, frame: bytes) -> None:
    """Text, compressed data, an unknown kind, a large ping."""
    with websocket(gate) as browser:
        browser.sendall(frame)
        assert all_of(browser) == b""


def test_a_browser_that_sends_very_many_small_frames_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    waits: list[float] = []

    async def sleep(seconds: float) -> None:
        waits.append(seconds)

    class Sink:
        def write(self, data: bytes) -> None:
            """Take it."""

        async def drain(self) -> None:
            """Wait for nothing."""

    async def copied(frames: int) -> None:
        source = asyncio.StreamReader()
        source.feed_data(b"\x82\x01a" * frames)
        source.feed_eof()
        unfinished = Unfinished(Limits).holder(lambda _: None)
        await gate_module._copy(source, cast(asyncio.StreamWriter, Sink()), unfinished)

    monkeypatch.setattr(asyncio, "sleep", sleep)
    asyncio.run(copied(gate_module._MOST_FRAMES))
    assert not waits
    asyncio.run(copied(10 * gate_module._MOST_FRAMES))
    assert len(waits) >= 1


def test_an_address_of_many_parameters_is_refused(open_gate: Gate) -> None:
    assert status(ask(open_gate, target="/?" + "a=b&" * 200)) == 400


def test_close_ends_what_is_open(behind: Behind) -> None:
    gate = Gate(listen("127.0.0.1:0", "--view"), behind.place)
    with connect(gate) as through, connect(gate) as silent:
        lines = ("GET / HTTP/1.1", "Host: localhost", *UPGRADE, "", "")
        through.sendall("\r\n".join(lines).encode())
        assert status(through.recv(4096)) == 101
        gate.close()
        assert all_of(through) == all_of(silent) == b""
    with pytest.raises(ConnectionRefusedError):
        connect(gate)


def test_what_is_behind_may_be_gone(closing: ExitStack) -> None:
    with socket.create_server(("127.0.0.1", 0)) as gone:
        place = gone.getsockname()
    gate = Gate(listen("127.0.0.1:0", "--view"), place)
    closing.callback(gate.close)
    assert ask(gate) == b""


# --- where it listens ----------------------------------------------------------------------------


def test_a_browser_that_comes_too_early_waits(behind: Behind, closing: ExitStack) -> None:
    listener = listen("127.0.0.1:0", "--view")
    with socket.create_connection(listener.getsockname()[:2], timeout=10) as early:
        early.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
        closing.callback(Gate(listener, behind.place).close)
        assert all_of(early).endswith(PAGE)


def test_a_port_that_is_taken_is_said_with_what_to_do() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(OSError, match=rf"no page at {address}: Address already in use; .*--view PORT, 0"):
            listen(address, "--view").close()


def test_a_host_that_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(*_: object, **__: object) -> Callable[..., object]:
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", nowhere)
    with pytest.raises(OSError, match=r"no page at nowhere:80: Name or service not known; .*--at HOST:PORT"):
        listen("nowhere:80", "--at").close()


def test_addresses_of_the_sixth_version_stand_in_brackets(behind: Behind, closing: ExitStack) -> None:
    try:
        listener = listen("[::1]:0", "--view")
    except OSError:
        pytest.skip("this machine has no IPv6")
    made = Gate(listener, behind.place)
    closing.callback(made.close)
    assert made.url == f"http://[::1]:{made.port}/"
    assert made.token is None


# --- what is behind ------------------------------------------------------------------------------


@pytest.mark.skipif(missing() is not None, reason="needs the extra viewer")
def test_viser_itself_is_not_where_a_web_site_would_look(monkeypatch: pytest.MonkeyPatch) -> None:
    import viser

    from simx_server.viewer.page.quiet_viser import open_browser_server

    places = set[str]()

    def note(*, host: str, port: int, verbose: bool) -> None:
        socket.create_server((host, port)).close()  # it is one of this machine's
        places.add(host)

    monkeypatch.setattr(viser, "ViserServer", note)
    for _ in range(5):
        open_browser_server()
    assert len(places) > 3
    assert all(re.fullmatch(r"127\.\d+\.\d+\.\d+", place) for place in places)
    assert "127.0.0.1" not in places
