"""Records of V-REP's files as they are written: damaged ones, doubled ones, points without bounds."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from simx_server.editing.saving.vrep.common import put_parameters
from simx_server.editing.saving.vrep.field import Writing
from simx_server.editing.saving.vrep.kinds.dummies import FORCE_SENSORS
from simx_server.editing.saving.vrep.kinds.shapes import SHAPES
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.vrep.writing.clouds import octree_cells, point_cells
from simx_server.scene.formats.vrep.writing.object_records import ObjectRecords
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list, record

WRITING = Writing(25, {})


def test_a_count_of_parameters_below_0_is_none() -> None:
    payload = record("Par", struct.pack("<i", -1)) + END
    records = RecordList("object", 25, [("Lsp", payload)])
    put_parameters(records, "Lsp", {"speed": "1"})
    (found,) = parse_list("parameters", records.raw("Lsp") or b"", 25).each("Par")
    assert found.startswith(struct.pack("<2i", 1, 5) + b"speed")


def test_a_shape_with_old_and_new_flags_is_respondable_by_both() -> None:
    records = ObjectRecords.new("SHP", 25)
    records.own.put_numbers("Ss3", 1)
    records.own.put_numbers("Ss2", 1)
    SHAPES["respondable"].put(records, False, WRITING)
    assert [records.own.numbers(tag) for tag in ("Ss3", "Ss2")] == [[0], [0]]


def test_a_force_sensor_that_breaks_has_no_thresholds_of_one_that_does_not() -> None:
    records = ObjectRecords.new("FSE", 25)
    put = FORCE_SENSORS["thresholds"].put
    put(records, (5.0, None, 1, "report"), WRITING)
    put(records, (6.0, None, 2, "break"), WRITING)
    assert records.own.numbers("Tre") == [6.0, 10.0, 2]
    assert not records.own.has("Tri")
    assert not records.own.has("_ri")


@pytest.mark.parametrize("edge", [0.0, 1e-200, float("inf"), float("nan")])
def test_cells_without_a_size_are_not_written(edge: float) -> None:
    points, colors = np.ones((1, 3)), np.zeros((1, 3), np.uint8)
    with pytest.raises(SceneError, match="do not fit"):
        octree_cells(points, colors, np.zeros(1, np.uint32), edge)
    with pytest.raises(SceneError, match="do not fit"):
        point_cells(points, colors, edge, 20)


@pytest.mark.parametrize("place", [1e200, float("inf"), float("nan")])
def test_points_without_a_place_are_not_written(place: float) -> None:
    with pytest.raises(SceneError, match="do not fit"):
        point_cells(np.full((1, 3), place), np.zeros((1, 3), np.uint8), 0.02, 20)
