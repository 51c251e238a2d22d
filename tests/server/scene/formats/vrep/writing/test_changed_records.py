"""Records of V-REP's files that are changed: float32 and float64, texts, bits, meshes, masked scripts."""

from __future__ import annotations

import numpy as np
import pytest
from vrep_meshes import normals_of
from vrep_packing import chunk, masked_bytes, numbers, text

from simx_server.scene.formats.vrep.chunks import Body, sections
from simx_server.scene.formats.vrep.decoding.meshes import read_pools
from simx_server.scene.formats.vrep.decoding.scripts import unmasked
from simx_server.scene.formats.vrep.writing.meshes import MeshPools
from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
from simx_server.scene.formats.vrep.writing.record_lists import RecordList, parse_list
from simx_server.scene.formats.vrep.writing.script_texts import masked


def joint(ser: int) -> RecordList:
    """Target velocity and force, an unknown record, and the bits of a joint."""
    payload = (
        numbers("Dmp", "2r", (0.5, 2.0), ser) + chunk("New", b"kept") + numbers("Va9", "B", (0x51,), ser)
    )
    return parse_list("JNT", payload + b"EOO", ser)


def tags(records: RecordList) -> list[str]:
    return [tag for tag, _ in records]


@pytest.mark.parametrize(("ser", "wanted"), [(21, ["Dmp"]), (24, ["Dmp", "_mp"]), (25, ["_mp"])])
def test_numbers_are_written_in_the_form_that_is_there(ser: int, wanted: list[str]) -> None:
    records = joint(ser)
    records.put_numbers("Dmp", 0.25, None)
    assert records.numbers("Dmp") == [0.25, 2.0]
    assert [tag for tag in tags(records) if tag in ("Dmp", "_mp")] == wanted
    assert records.raw("New") == b"kept"


def test_a_number_that_float32_cannot_hold_is_exact_in_old_files_too() -> None:
    records = joint(21)
    records.put_numbers("Dmp", 1 / 3, 1e300)
    assert records.numbers("Dmp") == [1 / 3, 1e300]
    assert tags(records) == ["Dmp", "New", "Va9", "_mp"]


def test_single_bits_change_and_missing_records_are_added_at_the_end() -> None:
    records = joint(21)
    records.put_bits("Va9", 0x30, 0x20)
    assert records.numbers("Va9") == [0x61]
    records.put_numbers("Jdt", 7, 2.0, 0.5)
    assert tags(records)[-1] == "Jdt"
    assert records.numbers("Jdt") == [7, 2.0, 0.5]


def test_an_object_keeps_what_stands_before_and_after_its_mark() -> None:
    payload = (
        numbers("Ids", "2i", (4, -1), 21) + chunk("Nme", text("old")) + b"NXT" + bytes(joint(21)) + b"EOO"
    )
    records = ObjectRecords.parse("JNT", payload, 21)
    assert bytes(records) == payload
    assert records.handles == (4, -1)
    records.common.put_text("Nme", "neu ä")
    assert bytes(records) == payload.replace(chunk("Nme", text("old")), chunk("Nme", text("neu ä")))


@pytest.mark.parametrize("source", ["", "a", "ab", "x = 'ä' -- \n" * 40])
def test_texts_are_masked_as_v_rep_does(source: str) -> None:
    assert unmasked(masked(source)) == source
    assert masked(source) == masked_bytes(source.encode() + b"\0")


@pytest.mark.parametrize("ser", [21, 25])
@pytest.mark.parametrize("other", [21, 25])
def test_meshes_of_another_version_come_behind_those_of_the_file(ser: int, other: int) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    normals = normals_of(points, faces)[:, 0]
    one, two = (MeshPools(RecordList("VIN", each)) for each in (ser, other))
    one.add(points, faces, normals)
    places = two.add(2 * points, faces, normals)
    brought = {pool: one.bring(two, pool, place) for pool, place in places.items()}
    assert brought == {"Vev": 1, "Inv": 1, "Nov": 1, "Vvd": 1}
    data = bytes(one.records)
    (chunks,) = sections(Body(memoryview(data), ""), ["VIN"], 0, len(data))
    found = read_pools(chunks)
    assert np.array_equal(found.vertices[1], (2 * points).astype(np.float32))
    assert np.array_equal(found.triangles[1], faces)
    assert np.allclose(found.normals[0], found.normals[1], atol=0.05)
