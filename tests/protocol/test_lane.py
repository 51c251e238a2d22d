"""The parts of the lane that client and server share: offers, frames, memory."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import read_line, running, spawn, wait_until

from simx_client.protocol.lane import offer
from simx_client.protocol.lane.frames import (
    FILE,
    MAX_FRAME,
    MEMORY,
    MESSAGE,
    BadFrame,
    Frames,
    file_frame,
    frame,
    has_unread,
    memory_frame,
    place_of,
    read_file,
)
from simx_client.protocol.lane.memory import ENDED, HEAD, SENT, MemoryReader, MemoryWriter

pytestmark = pytest.mark.skipif(not offer.is_possible(), reason="the lane needs Linux")


# --- offers -----------------------------------------------------------------------------------------


def test_an_offer_is_read_as_it_was_written() -> None:
    made = offer.Offer(offer.new_token(), offer.new_name())
    assert offer.read_offer(str(made)) == made


@pytest.mark.parametrize(
    "text",
    [
        "",
        "@",
        "token@/run/user/1000/bus",
        f"{'a' * 32}@../../{'b' * 10}",
        f"{'a' * 32}@{'b' * 16}/x",
        "\n" * 49,
    ],
)
def test_a_server_cannot_name_another_socket_or_send_other_bytes_there(text: str) -> None:
    assert offer.read_offer(text) is None


def test_a_folder_that_others_can_open_is_not_private(tmp_path: Path) -> None:
    folder = tmp_path / "simx"
    folder.mkdir(mode=0o700)
    assert offer.is_private(folder)
    for mode in (0o710, 0o704, 0o701, 0o777):
        folder.chmod(mode)
        assert not offer.is_private(folder)
    folder.chmod(0o700)
    link = tmp_path / "link"
    link.symlink_to(folder)
    assert not offer.is_private(link)
    assert not offer.is_private(tmp_path / "missing")


def test_the_folder_is_made_for_this_user_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = tmp_path / "a" / "simx", tmp_path / "b"
    monkeypatch.setattr(offer, "folders", lambda: [first, second])
    assert offer.made_folder() == second, "the first one has no folder above it"
    assert (second.stat().st_mode & 0o777, second.stat().st_uid) == (0o700, os.getuid())
    second.chmod(0o755)
    with pytest.raises(PermissionError):
        offer.made_folder()


def test_a_folder_with_a_path_that_is_too_long_for_sockets_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(offer, "folders", lambda: [tmp_path / ("x" * 100), tmp_path / "short"])
    assert len(str(tmp_path)) > 70 or offer.made_folder() == tmp_path / "short"


# --- frames -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1, 3, 5, 1000, 1 << 20])
def test_frames_are_found_however_the_bytes_come(size: int) -> None:
    messages = [b"", b"a", b"bc" * 40_000, b"end"]
    data = b"".join(map(frame, messages)) + memory_frame(7)
    frames = Frames()
    for begin in range(0, len(data), size):
        frames.add(data[begin : begin + size])
    *found, (kind, place) = frames.whole
    assert found == [(MESSAGE, each) for each in messages]
    assert (kind, place_of(place)) == (MEMORY, 7)
    assert frames.count == len(messages) + 1
    assert frames.missing == 0


def test_the_missing_bytes_of_a_frame_are_known() -> None:
    frames = Frames()
    frames.add(frame(bytes(100))[:3])
    assert frames.missing == 0, "its length is not known yet"
    frames.add(frame(bytes(100))[3:40])
    assert frames.missing == 65


@pytest.mark.parametrize("data", [frame(b"x" * 11), b"\0\0\0\0\x03", b"\xff" * 5])
def test_frames_that_are_too_long_or_unknown_are_refused(data: bytes) -> None:
    with pytest.raises(BadFrame):
        Frames(10).add(data)
    frames = Frames(10)
    frames.add(frame(b"good") + frame(b"also"))
    frames.add(data[:4])
    with pytest.raises(BadFrame):
        frames.add(data[4:])
    assert len(frames.whole) == 2


def test_a_memory_frame_must_have_a_place() -> None:
    with pytest.raises(BadFrame):
        place_of(b"abc")


# --- large messages as files --------------------------------------------------------------------------


@pytest.fixture
def file() -> Iterator[int]:
    made = os.memfd_create("test")
    os.write(made, b"a large message")
    yield made
    os.close(made)


def _length(length: int) -> bytes:
    """Return the payload of a file frame."""
    frames = Frames()
    frames.add(file_frame(length))
    ((kind, payload),) = frames.whole
    assert kind == FILE
    return payload


def test_a_message_comes_as_a_file(file: int) -> None:
    assert read_file(_length(15), file) == b"a large message"


@pytest.mark.parametrize(
    "payload", [b"", b"abc", bytes(9), _length(16), _length(MAX_FRAME + 1), _length((1 << 64) - 1)]
)
def test_a_file_of_another_length_than_its_frame_says_is_refused(file: int, payload: bytes) -> None:
    with pytest.raises(BadFrame):
        read_file(payload, file)


def test_bytes_that_the_other_end_has_not_read_are_known() -> None:
    near, far = socket.socketpair(socket.AF_UNIX)
    with near, far:
        assert not has_unread(near)
        near.send(b"ab")
        far.recv(1)
        assert has_unread(near)
        far.recv(1)
        assert not has_unread(near)


# --- memory -----------------------------------------------------------------------------------------


@pytest.fixture
def pair() -> Iterator[tuple[MemoryWriter, MemoryReader]]:
    writer = MemoryWriter(100_000)
    reader = MemoryReader(writer.file)
    os.close(writer.file)
    yield writer, reader
    writer.close()


def test_the_newest_message_is_returned_once(pair: tuple[MemoryWriter, MemoryReader]) -> None:
    writer, reader = pair
    assert reader.newest() is None
    writer.write(b"one")
    assert (reader.newest(), reader.newest()) == (b"one", None)
    writer.write(b"two")
    writer.write(b"three")
    writer.write(b"")
    assert (reader.newest(), reader.newest()) == (b"", None)


def test_a_head_says_whether_everything_was_taken(pair: tuple[MemoryWriter, MemoryReader]) -> None:
    writer, reader = pair
    assert reader.is_taken(reader.memory[HEAD], 0)
    writer.write(b"one")
    assert not reader.is_taken(reader.memory[HEAD], 0)
    reader.newest()
    taken = reader.memory[HEAD]
    assert reader.is_taken(taken, 0)
    assert not reader.is_taken(taken, 1)
    writer.count(1)
    assert not reader.is_taken(reader.memory[HEAD], 0)
    assert reader.is_taken(reader.memory[HEAD], 1)
    assert reader.memory[SENT] != ENDED
    writer.end()
    assert reader.memory[SENT] == ENDED
    assert not reader.is_taken(reader.memory[HEAD], 1)


_WRITES = """
from simx_client.protocol.lane.memory import MemoryWriter
writer = MemoryWriter(100_000)
print(writer.file, flush=True)
number = 0
while True:
    number = (number + 1) % 256
    writer.write(bytes([number]) * (390 * number))
"""


def test_messages_are_read_whole_while_another_process_replaces_them() -> None:
    with running(spawn("-c", _WRITES)) as process:
        file = os.open(f"/proc/{process.pid}/fd/{int(read_line(process))}", os.O_RDONLY)
        reader = MemoryReader(file)
        os.close(file)
        found = 0

        def read() -> None:
            nonlocal found
            if message := reader.newest():
                found += 1
                assert message == message[:1] * (390 * message[0])

        assert wait_until(lambda: found >= 2000, 60.0, turn=read)


def test_a_reader_can_count_frames_and_see_the_end(pair: tuple[MemoryWriter, MemoryReader]) -> None:
    writer, reader = pair
    assert (reader.sent, reader.has_ended) == (0, False)
    writer.count(3)
    assert (reader.sent, reader.has_ended) == (3, False)
    writer.end()
    assert reader.has_ended


def test_a_reader_can_neither_shorten_nor_write_the_memory() -> None:
    writer = MemoryWriter(10)
    try:
        for size in (0, 1 << 20):
            with pytest.raises(PermissionError):
                os.ftruncate(writer.file, size)
        reader = MemoryReader(writer.file)
        with pytest.raises(TypeError):
            reader.memory[0] = 1
    finally:
        os.close(writer.file)
        writer.close()
