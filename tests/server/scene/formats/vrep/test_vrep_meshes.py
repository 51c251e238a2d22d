"""How meshes are packed, against plain loops."""

from __future__ import annotations

import random
import struct

import numpy as np
import pytest
from vrep_packing import chunk, packed_indices, packed_normals

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.chunks import Body, Chunks, sections
from simx_server.scene.formats.vrep.decoding.meshes import agree, normals_of, triangles_of, vertices_of


def pool(tag: str, payload: bytes) -> tuple[Chunks, tuple[int, int]]:
    """A pool with one record, and the record's place."""
    data = chunk(tag, payload)
    (chunks,) = sections(Body(memoryview(data), "a test"), ["VIN"], 0, len(data))
    return chunks, chunks.places[tag]


def indices(tag: str, payload: bytes) -> list[int]:
    chunks, place = pool(tag, payload)
    return triangles_of(chunks, tag, place).reshape(-1).tolist()


def plain(payload: bytes) -> list[int]:
    """Unpack as the format is described."""
    (count,) = struct.unpack_from("<i", payload)
    found, place, last = [], 4, 0
    for _ in range(count):
        first = payload[place]
        extra = first >> 6
        value = first & 63
        for byte, shift in zip(range(1, extra + 1), (6, 14, 22), strict=False):
            value |= payload[place + byte] << shift
        last += value - (31, 8191, 2097151, 536870911)[extra]
        found.append(last)
        place += 1 + extra
    return found


@pytest.mark.parametrize("count", [0, 3, 300, 66_000])
@pytest.mark.parametrize("span", [20, 5_000, 1_000_000, 400_000_000])
def test_packed_indices_come_out_as_they_went_in(count: int, span: int) -> None:
    source = random.Random(count + span)
    expected = [source.randrange(span) for _ in range(count)]
    payload = packed_indices(expected)
    assert plain(payload) == expected
    assert indices("In2", payload) == expected


def test_differences_of_all_lengths_are_mixed() -> None:
    source = random.Random(1)
    expected = [source.randrange(1 << source.randrange(1, 29)) for _ in range(99_999)]
    assert indices("In2", packed_indices(expected)) == expected


@pytest.mark.parametrize("cut", [1, 2, 100])
def test_packed_indices_that_are_cut_off_are_an_error(cut: int) -> None:
    source = random.Random(2)
    payload = packed_indices([source.randrange(1_000_000) for _ in range(3000)])
    with pytest.raises(SceneError, match="fewer than the 3000 indices"):
        indices("In2", payload[:-cut])


def test_differences_that_lead_below_zero_are_an_error() -> None:
    with pytest.raises(SceneError, match="not between 0 and"):
        indices("In2", struct.pack("<i", 3) + bytes(3))


def test_plain_indices_are_read() -> None:
    assert indices("Ind", struct.pack("<6i", 0, 1, 2, 2, 1, 3)) == [0, 1, 2, 2, 1, 3]


def test_packed_normals_come_out_nearly_as_they_went_in() -> None:
    normals = np.random.default_rng(3).normal(size=(100, 3, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    chunks, place = pool("No2", packed_normals(normals))
    found = normals_of(chunks, "No2", place)
    assert found.shape == (100, 3, 3)
    assert np.linalg.norm(found, axis=2) == pytest.approx(1.0, abs=1e-6)
    assert np.einsum("ijk,ijk->ij", found, normals).min() > 0.99


def test_normals_without_length_become_zeros() -> None:
    values = np.array([[0, 0, 0], [0, 0, 5], [float("nan"), 1, 1]], "<f4")
    chunks, place = pool("Nor", values.tobytes())
    assert normals_of(chunks, "Nor", place).tolist() == [[[0, 0, 0], [0, 0, 1], [0, 0, 0]]]


def test_vertices_beyond_whole_ones_are_left_out() -> None:
    chunks, place = pool("Ver", struct.pack("<7f", *range(7)))
    assert vertices_of(chunks, "Ver", place).tolist() == [[0, 1, 2], [3, 4, 5]]


def test_normals_of_another_frame_do_not_agree() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    triangles = np.array([[0, 1, 2]], np.int32)
    up = np.tile(np.array([0, 0, 1], np.float32), (1, 3, 1))
    assert agree(vertices, triangles, up)
    assert not agree(vertices, triangles, up[:, :, ::-1])
    assert not agree(vertices, triangles, -up)
    assert agree(np.zeros((3, 3), np.float32), triangles, up)  # a triangle without area tells nothing
