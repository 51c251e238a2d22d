"""A seat's answers to the page: reports of a real world, and images with the renderer that casts rays."""

from __future__ import annotations

import logging
import select
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from real_world import BLOCKING, RealWorld

import simx_client as v
from simx_server.classroom import channel
from simx_server.classroom.desk import SIZES, Desk

pytestmark = pytest.mark.slow

ROOM = """
<mujoco model="room">
  <worldbody>
    <light pos="0 0 3"/>
    <body name="ball" pos="0 0 0.5"><freejoint/><geom size="0.2" rgba="1 0 0 1"/></body>
    <camera name="above" pos="0 0 3"/>
  </worldbody>
</mujoco>
"""
SOON = 60


class Seat:
    """A world with a desk, and the page's end of its channel."""

    def __init__(self, scene: Path, camera: str | None = None) -> None:
        self.world = RealWorld(scene)
        self.page, seat = channel.pair()
        self._seat = seat
        self.desk = Desk(seat, camera, self.world.parts, self.world.loop.service)
        self.client = self.world.client()

    def ask(self, **fields: Any) -> channel.Message:
        self.page.send(channel.packed({"id": 7, **fields}))
        while not select.select([self.page], [], [], 0)[0]:
            self.world.loop.turn(max_wait=0.01)
        message = channel.unpacked(self.page.recv(channel.MOST_BYTES))
        assert message.fields["id"] == 7
        return message

    def report(self) -> dict[str, Any]:
        return self.ask().fields["report"]

    def picture(self, size: str = "small") -> np.ndarray:
        picture = cv2.imdecode(np.frombuffer(self.ask(size=size).image, np.uint8), cv2.IMREAD_COLOR)
        assert picture is not None
        return picture

    def close(self) -> None:
        self.world.loop.service.queue.close_sockets()
        self.world.close()
        self.page.close()
        self._seat.close()


@pytest.fixture(autouse=True)
def rays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")


@pytest.fixture
def room(tmp_path: Path) -> Path:
    path = tmp_path / "room.xml"
    path.write_text(ROOM)
    return path


@pytest.fixture
def seat(room: Path) -> Iterator[Seat]:
    with closing(Seat(room)) as seat:
        yield seat


def test_report_tells_state_clients_and_the_last_error(seat: Seat) -> None:
    report = seat.report()
    assert (report["state"], report["scene"], report["connected"]) == ("stopped", "room", 1)
    assert (report["error"], report["error_ago"]) == ("", None)
    assert len(report["clients"]) == 1
    v.simxStartSimulation(seat.client, BLOCKING)
    v.simxGetObjectHandle(seat.client, "bal", BLOCKING)
    report = seat.report()
    assert report["state"] == "running"
    assert "no object named 'bal'" in report["error"]
    assert report["error_ago"] >= 0.0
    v.simxFinish(seat.client)
    assert seat.report()["connected"] == 0


def test_newest_error_counts_whether_a_call_or_the_log_has_it(seat: Seat) -> None:
    v.simxGetObjectHandle(seat.client, "bal", BLOCKING)
    with seat.world.loop.service.metrics.log.attached():
        logging.getLogger("simx_server.scripting").error("the script of ball ended")
        assert seat.report()["error"] == "the script of ball ended"
        v.simxGetObjectHandle(seat.client, "bell", BLOCKING)
        assert "'bell'" in seat.report()["error"]


def test_report_of_very_many_clients_with_long_names_is_short(
    seat: Seat, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.argv", ["\n" * 5000])
    for _ in range(30):
        seat.world.client()
    report = seat.report()
    assert report["connected"] == 31
    assert len(report["clients"]) == 8
    assert all(len(each["name"]) <= 80 for each in report["clients"])


@pytest.mark.parametrize("size", SIZES)
def test_image_has_the_size_of_tile_or_page(seat: Seat, size: str) -> None:
    height, width, _ = seat.picture(size).shape
    assert (width, height) == SIZES[size]


def test_image_shows_the_chosen_camera_or_the_overview_without_it(room: Path) -> None:
    with (
        closing(Seat(room, "above")) as above,
        closing(Seat(room)) as plain,
        closing(Seat(room, "gone")) as gone,
    ):
        from_above, overview = above.picture(), plain.picture()
        assert np.abs(from_above.astype(int) - overview).mean() > 1
        assert np.array_equal(gone.picture(), overview)


def test_image_follows_the_scene_that_a_client_loads(seat: Seat, room: Path) -> None:
    before = seat.picture()
    other = room.with_name("other.xml")
    other.write_text(ROOM.replace("1 0 0 1", "0 1 0 1").replace("above", "below"))
    assert v.simxLoadScene(seat.client, "other.xml", 0, BLOCKING) == 0
    after = seat.picture()
    assert np.abs(after.astype(int) - before).max() > 50


def test_page_that_reads_nothing_stops_no_seat(seat: Seat) -> None:
    for number in range(3000):
        with suppress(BlockingIOError):
            seat.page.send(channel.packed({"id": number}))
        seat.world.loop.turn(max_wait=0.0)
    assert v.simxGetObjectHandle(seat.client, "ball", BLOCKING)[0] == 0


def test_seat_goes_on_when_the_page_is_gone(seat: Seat) -> None:
    seat.page.close()
    for _ in range(3):
        seat.world.loop.turn(max_wait=0.01)
    assert v.simxGetObjectHandle(seat.client, "ball", BLOCKING)[0] == 0
