"""Damaged files: an error that names the record, its place and the program; or a note where a default does."""

from __future__ import annotations

import struct
from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest
from vrep_packing import chunk, listed
from vrep_writer import VrepWriter

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep import chunks, reading
from simx_server.scene.formats.vrep.decoding import common, shapes
from simx_server.scene.formats.vrep.objects import Joint, Shape, VisionSensor
from simx_server.scene.formats.vrep.reading import read_file

NAN, INF = float("nan"), float("inf")


def read(writer: VrepWriter) -> object:
    return read_file(writer.bytes(compression=0), "scene.ttt")


def damaged(make: Callable[[VrepWriter], object], message: str, ser: int = 21) -> None:
    """Check that what `make` writes is an error with this message, which tells place and program."""
    writer = VrepWriter(ser)
    make(writer)
    with pytest.raises(SceneError, match=message) as error:
        read(writer)
    assert f"saved by {'V-REP 3.5.0' if ser == 21 else 'CoppeliaSim 4.7.0'} (format {ser})" in str(
        error.value
    )
    assert " at byte " in str(error.value)


@pytest.mark.parametrize("ser", [21, 25])
@pytest.mark.parametrize("number", [NAN, INF, -INF])
def test_a_pose_that_is_not_finite_is_an_error(ser: int, number: float) -> None:
    damaged(lambda w: w.dummy("d", position=(0, number, 0)), "'Cfq'.*not finite", ser)


def test_a_quaternion_of_length_zero_is_an_error() -> None:
    damaged(lambda w: w.dummy("d", quaternion=(0, 0, 0, 0)), "quaternion of length 0")


def test_a_quaternion_of_another_length_is_scaled() -> None:
    writer = VrepWriter(21)
    writer.dummy("d", quaternion=(2, 0, 0, 0))
    (item,) = read_file(writer.bytes(), "a").objects.values()
    assert item.pose[1] == (1, 0, 0, 0)


def test_two_objects_of_one_handle_are_an_error() -> None:
    def make(writer: VrepWriter) -> None:
        writer.dummy("a", handle=3)
        writer.dummy("b", handle=3)

    damaged(make, "handle 3, which another object has")


def test_a_negative_handle_is_an_error() -> None:
    damaged(lambda w: w.dummy("a", handle=-7), "handle -7, which is negative")


def test_an_absent_parent_is_an_error() -> None:
    damaged(lambda w: w.dummy("a", parent=5), "object 0 has the parent 5, which is not in the file")


def test_an_object_above_itself_is_an_error() -> None:
    def make(writer: VrepWriter) -> None:
        writer.dummy("a", handle=0, parent=1)
        writer.dummy("b", handle=1, parent=2)
        writer.dummy("c", handle=2, parent=0)

    damaged(make, "object 0 is among its own ancestors")


def test_a_long_chain_of_objects_is_checked_in_one_pass() -> None:
    writer = VrepWriter(21)
    for number in range(3000):
        writer.dummy(f"d{number}", parent=number - 1)
    assert len(read_file(writer.bytes(compression=0), "a").objects) == 3000


def test_a_record_longer_than_its_list_is_an_error() -> None:
    damaged(
        lambda w: w.records.append(b"SHP" + struct.pack("<I", 99) + b"x"), "'SHP' wants 99 bytes where 4 are"
    )


def test_a_record_that_is_too_short_is_an_error() -> None:
    damaged(lambda w: w.other("JNT", "j", chunk("Jtt", b"\1\2")), "'Jtt'.*has 2 bytes where 4 are needed")


def test_an_absent_record_that_is_needed_is_an_error() -> None:
    damaged(lambda w: w.other("JNT", "j"), r"'Jtt' \(JNT\) of object 0 \(JNT\) is missing")


def test_a_sensor_of_an_unknown_form_keeps_its_place_and_is_noted() -> None:
    writer = VrepWriter(21)
    writer.other("RSN", "eye", position=(1, 0, 0))
    file = read_file(writer.bytes(), "a")
    (sensor,) = file.objects.values()
    assert sensor.pose[0] == (1, 0, 0)
    assert file.notes[0].startswith("defaults are taken: record 'Ccp' (RSN) of object 0 (RSN) is missing")


def test_a_collection_of_an_unknown_form_is_left_out_and_noted() -> None:
    writer = VrepWriter(21)
    writer.records.append(listed("GRP", chunk("Grn", struct.pack("<i", 0))))
    file = read_file(writer.bytes(), "a")
    assert file.collections == []
    assert file.notes[0].startswith("left out: record 'Gix' (GRP) of GRP is missing")
    assert "damaged" not in file.notes[0]


def test_an_absent_end_is_an_error() -> None:
    damaged(lambda w: w.records.append(b"PPL" + struct.pack("<I", 3)), "the end mark 'EOF' is missing")


def test_bytes_after_the_end_are_an_error() -> None:
    damaged(lambda w: w.records.append(b"EOFabc"), "6 bytes follow the end mark")


def test_a_mark_of_a_list_outside_of_lists_is_an_error() -> None:
    damaged(lambda w: w.records.append(b"EOO"), "outside of all records")


def test_an_index_beyond_the_pools_is_an_error() -> None:
    mesh = b"".join(chunk(tag, struct.pack("<i", 4)) for tag in ("Vev", "Inv", "Nov"))
    leaf = chunk("Mas", bytes(4)) + b"EOO" + mesh + b"EOO"
    damaged(
        lambda w: w.other("SHP", "s", listed("Ge2", chunk("Gst", leaf))), "'Vev'.*is 4, but the file has 0"
    )


@pytest.mark.parametrize("ser", [17, 18, 25])
def test_an_index_beyond_the_vertices_is_an_error(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.shape("s", mesh=(np.zeros((3, 3)), np.array([[0, 1, 3]])))
    with pytest.raises(SceneError, match="names vertex 3, but there are 3"):
        read(writer)


def test_an_index_below_zero_is_an_error() -> None:
    writer = VrepWriter(25)
    writer.shape("s", mesh=(np.zeros((3, 3)), np.array([[0, 1, -1]])))
    with pytest.raises(SceneError, match="index below 0"):
        read(writer)


def test_a_vertex_that_is_not_finite_is_an_error() -> None:
    writer = VrepWriter(21)
    writer.shape("s", mesh=(np.array([[0, 0, 0], [1, 0, 0], [0, NAN, 0]]), np.array([[0, 1, 2]])))
    with pytest.raises(SceneError, match="coordinate that is not finite"):
        read(writer)


def test_groups_that_are_nested_too_deep_are_an_error() -> None:
    group = chunk("Mas", bytes(4)) + b"EOO"
    for _ in range(200):
        group = chunk("Wrp", group) + b"EOO"
    damaged(lambda w: w.other("SHP", "s", listed("Ge2", chunk("Gsg", group))), "nested more than 32 deep")


def test_cells_that_are_nested_too_deep_are_an_error() -> None:
    head = struct.pack("<B5f", 2, 1, 0.1, 0, 0, 0)
    damaged(lambda w: w.other("OCT", "o", chunk("Co2", head + b"\0\1" * 60)), "nested more than 24 deep")


@pytest.mark.parametrize("data", [b"", b"\0\0" * 7, b"\2\0" * 8, b"\0\2" * 8, b"\0\0" * 9, b"\1\0\0"])
def test_cells_that_do_not_fill_their_record_are_an_error(data: bytes) -> None:
    head = struct.pack("<B5f", 2, 1, 0.1, 0, 0, 0)
    damaged(lambda w: w.other("OCT", "o", chunk("Co2", head + data)), "'Co2'.*(no cell|after its last cell)")


def test_a_texture_with_too_few_pixels_is_an_error() -> None:
    records = chunk("Ipa", struct.pack("<3i", 1, 1000, 1000)) + chunk("Img", bytes(12))
    damaged(lambda w: w.records.append(listed("TEX", records)), "12 bytes for 1000 x 1000 pixels")


def test_a_height_field_with_too_few_heights_is_an_error() -> None:
    field = chunk("Ppr", struct.pack("<i3f", 7, 1, 1, 1)) + chunk("Hfd", struct.pack("<2i", 50000, 50000))
    leaf = chunk("Mas", bytes(4)) + b"EOO" + field + b"EOO"
    damaged(
        lambda w: w.other("SHP", "s", listed("Ge2", chunk("Gst", leaf))),
        "50000 columns and 50000 rows but has 0",
    )


def test_packed_indices_that_are_not_there_are_an_error() -> None:
    pools = listed("VIN", chunk("In2", struct.pack("<i", 3) + b"\x20\x21"))
    damaged(lambda w: w.records.append(pools), "'In2'.*promises 3 indices in 2 bytes")


def test_an_engine_with_too_few_numbers_is_an_error() -> None:
    damaged(
        lambda w: w.other(
            "JNT", "j", chunk("Jtt", struct.pack("<i", 10)) + chunk("BtN", struct.pack("<2i", 2**30, 0))
        ),
        "'BtN'.*1073741824 real and 0 whole numbers in 8 bytes",
    )


def test_an_unknown_type_of_joint_is_an_error() -> None:
    records = chunk("Jtt", struct.pack("<i", 13))
    damaged(lambda w: w.other("JNT", "j", records), "has the type 13; valid is 10 revolute")


def test_an_unknown_way_of_control_is_noted() -> None:
    writer = VrepWriter(25)
    writer.other("JNT", "j", chunk("Jtt", struct.pack("<i", 10)) + chunk("Dcm", struct.pack("<i", 64)))
    file = read_file(writer.bytes(), "a")
    (joint,) = file.objects.values()
    assert isinstance(joint, Joint)
    assert joint.control == "velocity"
    assert "unknown way of control 64; velocity control is taken" in file.notes[0]


def test_a_number_that_is_not_finite_and_not_needed_is_noted() -> None:
    writer = VrepWriter(21)
    writer.joint("j", max_force=NAN)
    file = read_file(writer.bytes(), "a")
    (joint,) = file.objects.values()
    assert isinstance(joint, Joint)
    assert (joint.max_force, joint.target_velocity) == (0.0, 0.0)
    assert file.notes == ["record 'Dmp' (JNT) of object 0 (JNT) has a number that is not finite"]


def test_an_unknown_primitive_is_drawn_as_its_mesh() -> None:
    writer = VrepWriter(21)
    writer.shape("s", cuboid=(1, 1, 1))
    record = writer.records[0]
    place = record.index(b"Ppr") + 7
    writer.records[0] = record[:place] + struct.pack("<i", 77) + record[place + 4 :]
    file = read_file(writer.bytes(), "a")
    (shape,) = file.objects.values()
    assert isinstance(shape, Shape)
    assert len(shape.leaves[0].triangles) == 12
    assert "unknown primitive 77" in file.notes[0]


def test_a_time_step_that_cannot_be_is_noted() -> None:
    writer = VrepWriter(21)
    writer.settings(time_step=-1.0)
    file = read_file(writer.bytes(), "a")
    assert file.settings.time_step == 0.05
    assert "time step -1.0 s" in file.notes[0]


def test_notes_are_counted_beyond_a_hundred() -> None:
    writer = VrepWriter(21)
    for number in range(150):
        writer.joint(f"j{number}", max_force=NAN)
    notes = read_file(writer.bytes(compression=0), "a").notes
    assert len(notes) == 101
    assert notes[-1] == "and others"


@pytest.mark.parametrize(
    ("module", "name", "record"),
    [
        (chunks, "MOST_LISTS", lambda w: w.other("GRH", "g", listed("Ghd") * 50)),
        (shapes, "MOST_LEAVES", lambda w: w.shape("s", leaves=[{"cuboid": (1, 1, 1)}] * 50)),
        (reading, "MOST_OBJECTS", lambda w: [w.dummy(f"d{n}") for n in range(50)]),
        (reading, "MOST_RECORDS", lambda w: w.records.extend([chunk("GHO")] * 50)),
        (common, "MOST_BLOCKS", lambda w: w.scene_data({str(n): b"" for n in range(50)})),
        (common, "MOST_PARAMETERS", lambda w: w.dummy("d", parameters=[("a", "b", "c")] * 50)),
    ],
)
@pytest.mark.parametrize("ser", [21, 25])
def test_more_than_a_limit_is_an_error(
    module: ModuleType,
    name: str,
    record: Callable[[VrepWriter], object],
    ser: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    writer = VrepWriter(ser)
    record(writer)
    read(writer)
    monkeypatch.setattr(module, name, 40)
    with pytest.raises(SceneError, match=r"40|too many"):
        read(writer)


def test_a_resolution_that_cannot_be_is_noted() -> None:
    writer = VrepWriter(21)
    writer.vision_sensor("eye", resolution=(-5, 2**31 - 1))
    file = read_file(writer.bytes(), "a")
    (sensor,) = file.objects.values()
    assert isinstance(sensor, VisionSensor)
    assert sensor.resolution == (256, 256)
    assert "resolution -5 x 2147483647" in file.notes[0]


@pytest.mark.parametrize("count", [3, 2])
def test_texture_coordinates_that_do_not_suit_the_mesh_are_noted(count: int) -> None:
    coordinates = np.arange(2.0 * count).reshape(count, 2)
    writer = VrepWriter(21)
    texture = writer.texture(np.zeros((2, 2, 3)))
    triangle = (np.eye(3), np.array([[0, 1, 2]]))
    writer.shape("s", mesh=triangle, texture=texture, texture_coordinates=coordinates)
    file = read_file(writer.bytes(), "a")
    (shape,) = file.objects.values()
    assert isinstance(shape, Shape)
    use = shape.leaves[0].texture
    assert use is not None
    if count == 3:
        assert use.coordinates is not None
        assert use.coordinates.tolist() == coordinates.tolist()
    else:
        assert use.coordinates is None
        assert "2 texture coordinates for 3 corners" in file.notes[0]
