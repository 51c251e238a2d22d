"""Values as bytes and back: types are kept exactly, and bytes from elsewhere execute nothing."""

from __future__ import annotations

from enum import IntEnum
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from simx_server.files.library import find_scene
from simx_server.history.models import pack_model, unpack_model
from simx_server.history.packing import NotPackable, pack, unpack
from simx_server.joints.stepping.position_control import PositionMemory
from simx_server.scene.formats.exporting.check import differing_arrays
from simx_server.scene.formats.loader import load_scene, load_text
from simx_server.scene.objects import ObjectKind, SceneObject

OBJECT = SceneObject(3, "box", ObjectKind.SHAPE, -1, "body", "box", 1, 1, sensors=(4, 5))
WITH_DATA = """
<mujoco>
  <asset>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 2"/>
    <hfield name="hill" nrow="2" ncol="3" size="1 1 1 0.1" elevation="0 1 2 3 4 5"/>
  </asset>
  <worldbody>
    <geom name="ground" type="hfield" hfield="hill"/>
    <body name="wedge" pos="0.1 0.2 3.3"><freejoint/><geom name="wedge" type="mesh" mesh="wedge"/></body>
  </worldbody>
</mujoco>
"""


@pytest.mark.parametrize(
    "value",
    [
        (1, 2.5, "text \udc80", b"\0", None, True, [1, (2,), {"a": (3,)}]),
        {(1, "x"): [], 2: {"nested": ()}},
        {1, 2},
        frozenset(("a",)),
        {"state": (1 << 127) - 1, "more": (-(1 << 90), 3)},
        ObjectKind.DUMMY,
        OBJECT,
        Path("some/where"),
    ],
)
def test_a_value_comes_back_with_its_types(value: Any) -> None:
    found = unpack(pack(value))
    assert found == value
    assert repr(found) == repr(value)


def test_arrays_come_back_bit_for_bit_and_can_be_written() -> None:
    values = (
        np.array([[0.1, -0.0], [np.nan, 1e308]]),
        np.arange(3, dtype=np.int8),
        np.zeros((0, 3), np.float32),
    )
    for value in values:
        found = unpack(pack(value))
        assert (found.dtype, found.shape, found.tobytes()) == (value.dtype, value.shape, value.tobytes())
        found[...] = 0
    memory = unpack(pack(PositionMemory({1: 0}, np.ones(1), np.zeros(1))))
    assert isinstance(memory, PositionMemory)
    assert memory.places == {1: 0}


class Foreign(IntEnum):
    """Not of the server."""

    ONE = 1


@pytest.mark.parametrize("value", [object(), Foreign.ONE, np.array([None]), lambda: None])
def test_what_is_not_the_servers_own_is_refused(value: Any) -> None:
    with pytest.raises(NotPackable):
        pack((value,))


@pytest.mark.parametrize(
    "tree",
    [
        [7, "os:system", "true"],
        [7, "simx_server.app.cli:main"],
        [7, "simx_server.history.journal:Journal"],
        [7, "simx_server.history.journal:os.path"],
        [9, "collections:OrderedDict", 1],
        [8, "simx_server.history.nothing:Such", 1],
        [5, "|O", [1], b"12345678"],
        [99, 1],
        [],
    ],
)
def test_bytes_that_name_other_things_are_refused(tree: Any) -> None:
    packed = msgpack.packb(tree)
    assert packed is not None
    with pytest.raises(NotPackable):
        unpack(packed)


@pytest.mark.parametrize("scene", ["ur5_rg2_kinect", "line_follower", WITH_DATA])
def test_a_model_comes_back_bit_for_bit_with_a_spec_for_the_next_edit(scene: str) -> None:
    made, model = load_text(scene) if "<" in scene else load_scene(find_scene(scene))
    again, same = unpack_model(pack_model(made, model))
    assert not differing_arrays(model, same)
    assert again.objects == made.objects
    assert (again.next_handle, again.welded_bodies) == (made.next_handle, made.welded_bodies)
    compiled = again.spec.copy().compile()
    assert (compiled.nbody, compiled.ngeom, compiled.nmeshvert, compiled.nhfielddata) == (
        model.nbody, model.ngeom, model.nmeshvert, model.nhfielddata,
    )  # fmt: skip
    assert np.array_equal(compiled.mesh_vert, model.mesh_vert)
    assert np.array_equal(compiled.hfield_data, model.hfield_data)
