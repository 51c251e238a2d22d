"""The header: versions, compression, and what is found under the name of such a file but is something else."""

from __future__ import annotations

import pytest
from vrep_packing import header
from vrep_writer import VrepWriter

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.reading import read_file


def small() -> VrepWriter:
    writer = VrepWriter(21)
    writer.dummy("only")
    return writer


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "empty"),
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:1\nsize 2\n",
            "Git LFS pointer.*git lfs pull",
        ),
        (b"<?xml version='1.0'?><CoppeliaSim/>", "XML"),
        (b"\xef\xbb\xbf<CoppeliaSim>", "XML"),
        (b"VR", "ends within the header"),
        (b"VREP" + bytes(100), "ends within the header, at byte 104"),
        (b"PK\x03\x04 something", r"begins with 'PK\\x03\\x04'"),
        (b"\n<!DOCTYPE html><html>", "it is a web page"),
    ],
)
def test_what_is_no_such_file_is_named(data: bytes, message: str) -> None:
    with pytest.raises(SceneError, match=message) as error:
        read_file(data, "robot.ttt")
    assert str(error.value).startswith("'robot.ttt' cannot be read: ")


@pytest.mark.parametrize(
    ("serialization", "message"), [(26, "CoppeliaSim 4.11.0.*newer"), (12, "V-REP 3.0"), (-1, "V-REP 3.0")]
)
def test_a_version_that_is_not_read_is_named(serialization: int, message: str) -> None:
    program = (4, 11, 0) if serialization > 25 else (2, 6, 0)
    data = header(b"EOF", serialization=serialization, program=program, compression=0, kind=1) + b"EOF"
    with pytest.raises(SceneError, match=message):
        read_file(data, "scene.ttt")


def test_a_file_without_compression_is_read() -> None:
    assert [item.name for item in read_file(small().bytes(compression=0), "a").objects.values()] == ["only"]


def test_another_compression_is_an_error() -> None:
    data = bytearray(small().bytes())
    data[12] = 2
    with pytest.raises(SceneError, match="compression 2"):
        read_file(bytes(data), "scene.ttt")


@pytest.mark.parametrize("change", [-1, 1])
def test_an_uncompressed_body_of_another_length_is_an_error(change: int) -> None:
    data = small().bytes(compression=0)
    data = data[:change] if change < 0 else data + b"\0"
    with pytest.raises(SceneError, match="its header says"):
        read_file(data, "scene.ttt")


def test_the_end_of_a_scene_tells_its_kind_where_the_header_does_not() -> None:
    writer = small()
    assert read_file(writer.bytes(), "a").is_model
    writer.settings()
    assert not read_file(writer.bytes(), "a").is_model
