"""Windows of cv2.imshow in the web viewer: a script without a display shows them there, and gets keys from there."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import msgpack
import numpy as np
import pytest
from processes import PENDULUM, server, wait_until
from routers import free_ports

from simx_client import Client
from simx_client.launch.windows import screen as s
from simx_client.launch.windows.screen import NoScreen
from simx_client.launch.windows.viewer import Viewer
from simx_client.protocol.add_ons import windows as w
from simx_server.errors import CommandError
from simx_server.viewer.windows import (
    KEPT,
    MOST_EVENTS,
    MOST_HELD,
    MOST_LETTERS,
    MOST_SENT,
    MOST_WINDOWS,
    Windows,
)

pytestmark = pytest.mark.slow

JPEG = cv2.imencode(".jpg", np.zeros((4, 4, 3), np.uint8))[1].tobytes()


def window(number: Any = 1, **others: Any) -> dict[str, Any]:
    return {w.NUMBER: number, w.TITLE: "camera", w.TEXT: "", w.TRACKBARS: [], w.IMAGE: JPEG, **others}


class Kept:
    """The server's add-on, with a clock of the test's."""

    def __init__(self, *, has_viewer: bool = False) -> None:
        self.now = 0.0
        self.add_on = Windows(has_viewer=has_viewer, clock=lambda: self.now)

    def ask(self, function: str, **told: Any) -> Any:
        return msgpack.unpackb(self.add_on.call(function, [], [], [], msgpack.packb(told))[3])

    def exchange(self, *windows: dict[str, Any], owner: str = "script") -> dict[str, Any]:
        return self.ask(w.EXCHANGE, owner=owner, windows=list(windows))

    def shown(self, **known: int) -> list[dict[str, Any]]:
        return self.ask(w.SHOWN, known={key.replace("_", "/"): version for key, version in known.items()})[
            w.WINDOWS
        ]


@pytest.fixture
def kept() -> Kept:
    return Kept()


def test_images_come_once_and_events_go_back(kept: Kept) -> None:
    kept.exchange(window())
    (shown,) = kept.shown()
    assert (shown[w.TITLE], shown[w.IMAGE]) == ("camera", JPEG)
    assert kept.shown(script_1=shown[w.VERSION])[0][w.IMAGE] is None
    kept.exchange(window(**{w.IMAGE: None, w.TITLE: "other"}))
    assert kept.shown()[0][w.IMAGE] == JPEG, "the image before is still shown"
    kept.ask(w.ACT, owner="script", event=[w.KEY, 113])
    kept.ask(w.ACT, owner="script", event=[w.DRAGGED, 1, "speed", 5])
    assert kept.exchange(window())[w.EVENTS] == [[w.KEY, 113], [w.DRAGGED, 1, "speed", 5]]
    assert kept.exchange(window())[w.EVENTS] == []


def test_windows_go_with_their_script(kept: Kept) -> None:
    kept.exchange(window(), owner="one")
    kept.exchange(window(), owner="two")
    kept.exchange(owner="one")
    assert [each[w.OWNER] for each in kept.shown()] == ["two"]
    kept.now += KEPT
    assert kept.shown() == []
    with pytest.raises(CommandError, match="has gone"):
        kept.ask(w.ACT, owner="two", event=[w.KEY, 113])


def test_server_tells_whether_somebody_can_see(kept: Kept) -> None:
    assert not kept.exchange()[w.IS_WATCHED]
    kept.shown()
    assert kept.exchange()[w.IS_WATCHED]
    kept.now += KEPT
    assert not kept.exchange()[w.IS_WATCHED]
    assert Kept(has_viewer=True).exchange()[w.IS_WATCHED], "it starts, and has not asked yet"


@pytest.mark.parametrize(
    "told",
    [
        {w.OWNER: 1, w.WINDOWS: []},
        {w.WINDOWS: []},
        {w.OWNER: "a", w.WINDOWS: None},
        {w.OWNER: "a", w.WINDOWS: [1]},
        {w.OWNER: "a", w.WINDOWS: [window()] * (MOST_WINDOWS + 1)},
        {w.OWNER: "a", w.WINDOWS: [window(2**40)]},
        {w.OWNER: "a", w.WINDOWS: [window(True)]},
        {w.OWNER: "a", w.WINDOWS: [window(**{w.TITLE: b"x"})]},
        {w.OWNER: "a", w.WINDOWS: [window(**{w.IMAGE: b"<svg>"})]},
        {w.OWNER: "a", w.WINDOWS: [window(**{w.IMAGE: JPEG + bytes(w.LARGEST_IMAGE)})]},
        {w.OWNER: "a", w.WINDOWS: [window(**{w.TRACKBARS: [["a", 1, 2]]})]},
        {w.OWNER: "a", w.WINDOWS: [window(**{w.TRACKBARS: [["a", 1, 5, 2]]})]},
        {w.OWNER: "a", w.WINDOWS: [window(**{w.TRACKBARS: [["a", 1.5, 0, 2]]})]},
    ],
)
def test_unusable_windows_are_refused(kept: Kept, told: dict[str, Any]) -> None:
    with pytest.raises(CommandError):
        kept.ask(w.EXCHANGE, **told)
    assert kept.shown() == []


@pytest.mark.parametrize(
    "event", [None, [], ["key"], ["key", "a"], [["key"], 1], ["mouse", 1], ["dragged", 1, 2, 3]]
)
def test_unusable_events_are_refused(kept: Kept, event: object) -> None:
    kept.exchange(window())
    with pytest.raises(CommandError):
        kept.ask(w.ACT, owner="script", event=event)
    assert kept.exchange(window())[w.EVENTS] == []


@pytest.mark.parametrize("buffer", [b"", b"\xc1", b"\x93\x01", msgpack.packb([1]), b"\x91" * 100_000])
def test_unusable_bytes_are_refused(kept: Kept, buffer: bytes) -> None:
    for function in (w.EXCHANGE, w.SHOWN, w.ACT):
        with pytest.raises(CommandError):
            kept.add_on.call(function, [], [], [], buffer)


def test_what_is_kept_is_bounded(kept: Kept) -> None:
    kept.exchange(window(**{w.TITLE: "x" * 100_000}))
    assert len(kept.shown()[0][w.TITLE]) == MOST_LETTERS
    for code in range(MOST_EVENTS + 5):
        kept.ask(w.ACT, owner="script", event=[w.KEY, code])
    assert [code for _, code in kept.exchange(window())[w.EVENTS]] == list(range(5, MOST_EVENTS + 5))
    for number in range(15):
        kept.exchange(window(), owner=f"other {number}")
    with pytest.raises(CommandError, match="16 scripts"):
        kept.exchange(window(), owner="one too many")


LARGE = JPEG + bytes(w.LARGEST_IMAGE - len(JPEG))


def test_images_of_all_scripts_together_are_bounded_and_an_answer_has_some_of_them(kept: Kept) -> None:
    fitting = MOST_HELD // len(LARGE)
    half = [window(number, **{w.IMAGE: LARGE}) for number in range(fitting // 2)]
    for owner in ("one", "other"):
        kept.exchange(*half, owner=owner)
    with pytest.raises(CommandError, match="hold at most"):
        kept.exchange(window(**{w.IMAGE: LARGE}), owner="one too many")
    known: dict[str, int] = {}
    for _ in range(fitting):
        shown = kept.ask(w.SHOWN, known=known)[w.WINDOWS]
        images = [each for each in shown if each[w.IMAGE]]
        assert sum(len(each[w.IMAGE]) for each in images) < MOST_SENT + len(LARGE)
        known |= {f"{each[w.OWNER]}/{each[w.NUMBER]}": each[w.VERSION] for each in shown if each[w.VERSION]}
        if not images:
            break
    assert len(known) == fitting


# --- over the network ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    scene = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    scene.write_text(PENDULUM)
    with server(scene) as process:
        yield f"127.0.0.1:{process.port}"


class Visitor:
    """Somebody at a web viewer."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def ask(self, function: str, **told: Any) -> Any:
        buffer = msgpack.packb(told)
        return msgpack.unpackb(
            self._client.call(function, w.ADD_ON, buffer=buffer, script_type=w.ADD_ON_TYPE).buffer
        )

    def shown(self) -> list[dict[str, Any]]:
        return self.ask(w.SHOWN)[w.WINDOWS]


@pytest.fixture
def visitor(place: str) -> Iterator[Visitor]:
    with Client(place) as client:
        yield Visitor(client)


def test_screen_of_the_viewer_shows_and_takes_keys(place: str, visitor: Visitor) -> None:
    visitor.shown()
    reports: queue.Queue[s.Message] = queue.Queue()
    screen = Viewer(cv2, place, reports.put, lambda reason: reports.put(("lost", reason)))
    image = np.full((900, 1800, 3), (200, 100, 50), np.uint8)
    for message in (
        (s.OPEN, 1, "camera", 1),
        (s.TRACKBAR, 1, "speed", 3, 0, 10),
        (s.TEXT, 1, "hello", 0),
        (s.SHOW, 1, 1800, 900, image.tobytes()),
    ):
        screen.tell(message)
    assert wait_until(lambda: bool(visitor.shown()) and bool(visitor.shown()[0][w.IMAGE]), 20)
    (shown,) = visitor.shown()
    assert (shown[w.TITLE], shown[w.TEXT], shown[w.TRACKBARS]) == ("camera", "hello", [["speed", 3, 0, 10]])
    picture = cv2.imdecode(np.frombuffer(shown[w.IMAGE], np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (640, 1280, 3), "large images are sent smaller"
    assert np.abs(picture[300, 600].astype(int) - (50, 100, 200)).max() < 4, "blue first again"
    for event in ([w.KEY, 113], [w.DRAGGED, 1, "speed", 8]):
        visitor.ask(w.ACT, owner=shown[w.OWNER], event=event)
    assert reports.get(timeout=20) == [w.KEY, 113]
    assert reports.get(timeout=20) == [w.DRAGGED, 1, "speed", 8]
    assert wait_until(lambda: visitor.shown()[0][w.TRACKBARS] == [["speed", 8, 0, 10]], 20)
    visitor.ask(w.ACT, owner=shown[w.OWNER], event=[w.CLOSED, 1])
    assert reports.get(timeout=20) == [w.CLOSED, 1]
    assert wait_until(lambda: visitor.shown() == [], 20)
    screen.close()


def test_window_goes_at_once_when_its_script_leaves(place: str, visitor: Visitor) -> None:
    visitor.shown()
    screen = Viewer(cv2, place, lambda report: None, lambda reason: None)
    screen.tell((s.OPEN, 1, "camera", 1))
    assert wait_until(lambda: len(visitor.shown()) == 1, 20)
    screen.close()
    assert visitor.shown() == []


def test_server_without_a_viewer_is_no_screen(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    with (
        server(tmp_path / "pendulum.xml") as process,
        pytest.raises(NoScreen, match="no web viewer \\(--view\\)"),
    ):
        Viewer(cv2, f"127.0.0.1:{process.port}", lambda report: None, lambda reason: None)


def test_lost_server_is_told(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    lost: queue.Queue[str] = queue.Queue()
    with server(tmp_path / "pendulum.xml") as process:
        where = f"127.0.0.1:{process.port}"
        with Client(where) as client:
            Visitor(client).shown()
        screen = Viewer(cv2, where, lambda report: None, lost.put)
        screen.tell((s.OPEN, 1, "camera", 1))
        process.kill()
        assert lost.get(timeout=30)
        screen.close()


def test_windows_of_a_script_on_the_starting_port_start_no_simulation(tmp_path: Path) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    observing, starting = free_ports(2)
    flags = ("--temporary-port", str(starting))
    with (
        server(tmp_path / "pendulum.xml", *flags, ports=(observing, starting)),
        Client(f"127.0.0.1:{observing}") as client,
    ):
        Visitor(client).shown()
        screen = Viewer(cv2, f"127.0.0.1:{starting}", lambda report: None, lambda reason: None)
        screen.tell((s.OPEN, 1, "camera", 1))
        assert wait_until(lambda: len(Visitor(client).shown()) == 1, 20)
        assert client.simulation.state == "stopped"
        screen.close()
