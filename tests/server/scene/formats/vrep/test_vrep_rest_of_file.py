"""Parts of a file beside shapes, joints and sensors, in files that the tests' own writer made."""

from __future__ import annotations

import struct
from typing import TypeVar

import numpy as np
import pytest
from vrep_packing import chunk, listed, masked_bytes
from vrep_writer import PROGRAMS, VrepWriter

from simx_server.scene.formats.vrep.decoding.numbers import as_typed
from simx_server.scene.formats.vrep.objects import (
    Camera,
    Engine,
    Graph,
    Light,
    OtherObject,
    Path,
    PointCloud,
    VrepFile,
    VrepObject,
)
from simx_server.scene.formats.vrep.reading import read_file

VERSIONS = pytest.mark.parametrize("ser", sorted(PROGRAMS))
Kind = TypeVar("Kind", bound=VrepObject)

REGULAR = """-- A comment
function sysCall_init()
    sim.handleSimulationStart()
end
function sysCall_actuation()
    sim.handleChildScripts(sim.syscb_actuation)
    sim.handleDynamics(sim.getSimulationTimeStep())
end
function sysCall_sensing()
    sim.handleProximitySensor(sim.handle_all_except_explicit)
    sim.handleVisionSensor(sim.handle_all_except_explicit)
end
"""


def read(writer: VrepWriter) -> VrepFile:
    return read_file(writer.bytes(), "test.ttt")


def only(writer: VrepWriter, kind: type[Kind]) -> Kind:
    """Read the file and return its only object of a kind."""
    (item,) = [each for each in read(writer).objects.values() if isinstance(each, kind)]
    return item


@VERSIONS
def test_settings_are_read(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.settings(
        time_step=0.01, physics_step=0.002, real_time=True, engine=1, gravity=(0, 0.1, -9.81), layers=0x13
    )
    settings = read(writer).settings
    assert (settings.time_step, settings.is_real_time) == (0.01, True)
    assert (settings.engine, settings.gravity, settings.visible_layers) == (Engine.ODE, (0, 0.1, -9.81), 0x13)


@VERSIONS
@pytest.mark.parametrize(
    ("choice", "step"), [(0, 0.2), (1, 0.1), (2, 0.05), (3, 0.025), (4, 0.01), (5, 0.003)]
)
def test_the_simulation_step_is_the_chosen_one(ser: int, choice: int, step: float) -> None:
    writer = VrepWriter(ser)
    writer.settings(time_step=0.003, choice=choice)
    settings = read(writer).settings
    assert (settings.time_step, settings.has_custom_step) == (step, choice == 5)


@pytest.mark.parametrize("number", [1 / 3, 0.05, 1e300, -9.81, 0.0])
def test_numbers_that_no_short_one_stands_for_stay(number: float) -> None:
    assert as_typed(number) == number
    assert abs(number) > 1e30 or as_typed(float(np.float32(number))) == pytest.approx(number, rel=1e-7)


@VERSIONS
def test_the_dynamics_step_is_that_of_the_engine(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.settings(physics_step=0.002)
    assert read(writer).settings.physics_step == 0.002


@VERSIONS
@pytest.mark.parametrize(("number", "is_newer"), [(None, False), (0, False), (283, True)])
def test_the_version_of_bullet_is_that_of_the_scene(ser: int, number: int | None, is_newer: bool) -> None:
    writer = VrepWriter(ser)
    writer.settings(bullet=number)
    assert read(writer).settings.has_newer_bullet is is_newer


@VERSIONS
@pytest.mark.parametrize("text", ["", "x", "ab", "sim.x()\n", "print('Größe', '→')\n" * 50])
def test_script_texts_are_unmasked(ser: int, text: str) -> None:
    writer = VrepWriter(ser)
    owner = writer.dummy("owner")
    number = writer.script(
        text, owner, threaded=True, parameters=[("speed", "m/s", "0.5"), ("on", "", "true")]
    )
    (script,) = read(writer).scripts
    assert (script.text, script.id, script.owner, script.object) == (text, number, owner, -1)
    assert (script.type, script.is_threaded, script.is_disabled) == (1, True, False)
    assert script.parameters == [("speed", "m/s", "0.5"), ("on", "", "true")]


def test_order_and_traversal_of_scripts_are_read() -> None:
    writer = VrepWriter(24)
    writer.script("x=1", writer.dummy("head"), order=2, traversal=1)
    writer.script("x=1", writer.dummy("tail"))
    assert [(each.order, each.traversal) for each in read(writer).scripts] == [(2, 1), (1, 0)]


def test_a_script_of_latin_letters_is_read() -> None:
    writer = VrepWriter(21)
    owner = writer.dummy("owner")
    records = chunk("Si2", struct.pack("<3i", 1, owner, 1))
    writer.records.append(listed("LST", records, chunk("Ste", masked_bytes("-- Größe".encode("cp1252")))))
    assert read(writer).scripts[0].text == "-- Größe"


def test_a_script_object_serves_its_parent() -> None:
    writer = VrepWriter(25)
    owner = writer.dummy("owner")
    handle = writer.script("#python\nimport math", owner, kind="customization", as_object=True)
    file = read(writer)
    (script,) = file.scripts
    assert (script.owner, script.object, script.language, script.type) == (owner, handle, "python", 6)
    item = file.objects[handle]
    assert isinstance(item, OtherObject)
    assert item.kind == "script"


def test_a_script_without_a_known_owner_has_none() -> None:
    writer = VrepWriter(21)
    writer.script("x=1", 77)
    assert read(writer).scripts[0].owner == -1


@pytest.mark.parametrize(
    ("text", "flags", "program", "expected"),
    [
        ("-- c\nrequire('defaultMainScript')\n", 0, (4, 7, 0), True),
        ('--lua\nrequire("defaultMainScript")', 0, (4, 7, 0), True),
        ("require('defaultMainScript-2')", 0, (4, 11, 0), True),
        (REGULAR, 0, (4, 7, 0), True),
        (REGULAR + "sim.setJointPosition(3,1)\n", 8, (4, 7, 0), False),
        (REGULAR + "while true do sim.handleGraph(1) end\n", 0, (4, 7, 0), False),
        ("sim.handleDynamics(0.05)", 0, (4, 7, 0), False),
        ("whatever()", 8, (3, 5, 0), True),
        ("whatever()", 0, (3, 5, 0), False),
    ],
)
def test_a_main_script_that_does_nothing_else_is_the_default(
    text: str, flags: int, program: tuple[int, int, int], expected: bool
) -> None:
    writer = VrepWriter(21 if program < (4, 0, 0) else 25, program)
    writer.script(text, flags=flags)
    assert read(writer).scripts[0].is_default_main is expected


@VERSIONS
def test_custom_data_of_the_scene_is_read(ser: int) -> None:
    blocks = {"CONF": b"\0\1\2", "longer tag": b"x" * 300, "empty": b""}
    writer = VrepWriter(ser)
    writer.scene_data(blocks)
    assert read(writer).custom_data == blocks


@pytest.mark.parametrize("ser", [22, 25])
def test_an_object_has_its_user_parameters(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.dummy("base", parameters=[("speed", "m/s", "0.5"), ("side", "", "left")])
    (base,) = read(writer).objects.values()
    assert base.parameters == [("speed", "m/s", "0.5"), ("side", "", "left")]


def test_an_object_has_references_to_others_by_tag() -> None:
    writer = VrepWriter(25)
    writer.dummy("base", references={"": [1, -1], "ik.tip": [1]})
    base, *_ = read(writer).objects.values()
    assert base.references == {"": [1, -1], "ik.tip": [1]}


def test_custom_data_of_plugins_is_left_out() -> None:
    writer = VrepWriter(21)
    writer.records.append(listed("CDS", chunk("Dat", struct.pack("<2i", 1000, 2) + b"ab")))
    assert read(writer).custom_data == {}


@VERSIONS
def test_registered_things_are_read(ser: int) -> None:
    writer = VrepWriter(ser)
    base, tip = writer.dummy("base"), writer.dummy("tip")
    group = writer.collection("robot", [(base, 1, True), (tip, 0, False)], overrides=True)
    writer.collision("crash", group, base)
    writer.distance("gap", base, threshold=0.25)
    elements = [{"tip": tip, "base": base, "constraints": 7}]
    writer.ik_group("ik", elements, iterations=9, damping=0.5, damped=True, explicit=True)
    writer.ik_group("small steps", elements, limits_steps=True)
    file = read(writer)
    (collection,) = file.collections
    assert (collection.id, collection.name, collection.overrides) == (group, "robot", True)
    assert collection.entries == [(base, 1, True), (tip, 0, False)]
    (collision,), (distance,) = file.collisions, file.distances
    assert (collision.name, collision.entity1, collision.entity2) == ("crash", group, base)
    assert (distance.name, distance.entity1, distance.entity2, distance.threshold) == ("gap", base, -1, 0.25)
    ik, small = file.ik_groups
    assert (ik.name, ik.iterations, ik.damping, ik.method) == ("ik", 9, 0.5, 1)
    assert (ik.is_enabled, ik.is_explicit, ik.ignores_steps) == (True, True, True)
    assert not small.ignores_steps
    (element,) = ik.elements
    assert (element.tip, element.base, element.constraints, element.enabled) == (tip, base, 7, True)


@VERSIONS
def test_an_old_user_interface_has_its_buttons(ser: int) -> None:
    writer = VrepWriter(ser)
    owner = writer.dummy("owner")
    buttons = [
        {"id": 3, "label": "Go", "down": "Stop", "at": (1, 2), "size": (4, 1), "attributes": 0x2058},
        {"id": 4, "attributes": 0x2052, "slider": 250},
    ]
    handle = writer.old_ui("panel", buttons, owner=owner, size=(8, 5), is_double=ser >= 25)
    (panel,) = read(writer).uis
    assert (panel.handle, panel.name, panel.object, panel.size) == (handle, "panel", owner, (8, 5))
    go, slider = panel.buttons
    assert (go.handle, go.label, go.down_label, go.position, go.size) == (3, "Go", "Stop", (1, 2), (4, 1))
    assert (go.attributes, slider.slider) == (0x2058, 250)


def test_a_user_interface_that_cannot_be_read_costs_a_note_and_not_the_scene() -> None:
    writer = VrepWriter(21)
    writer.dummy("owner")
    broken = listed("Btn", chunk("Bva", struct.pack("<3i", 0x2010, 1, 4)))
    writer.records.append(
        listed("BBK", chunk("Bkh", struct.pack("<i", 7)) + chunk("Bkn", struct.pack("<i", 1) + b"x") + broken)
    )
    writer.old_ui("panel", [{"id": 3}])
    file = read(writer)
    assert [ui.name for ui in file.uis] == ["panel"]
    assert [item.name for item in file.objects.values()] == ["owner"]
    assert any(note.startswith("left out: ") and "Bva" in note for note in file.notes)


@VERSIONS
def test_a_path_has_points_and_section(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.path(
        "track",
        [(0, 0, 0), (1, 2, 3, 0, 1, 0, 0)],
        closed=True,
        bezier=15,
        section=[(0.1, 0), (-0.1, 0)],
        scale=2.0,
    )
    path = only(writer, Path)
    first, second = path.points
    assert (first.pose[0], second.pose) == ((0, 0, 0), ((1, 2, 3), (0, 1, 0, 0)))
    assert (first.bezier, first.bezier_points) == ((0.5, 0.5), 15)
    assert (path.is_closed, path.attributes, path.is_shaped) == (True, 7, True)
    assert np.allclose(path.section, [(0.2, 0), (-0.2, 0)])


@VERSIONS
def test_an_octree_has_the_middles_of_its_cells(ser: int) -> None:
    middles = [(0.05, 0.05, 0.05), (-0.35, 0.15, 0.05), (0.25, -0.05, -0.15)]
    writer = VrepWriter(ser)
    writer.octree("cells", middles, 0.1, (1, 2, 3))
    cloud = only(writer, PointCloud)
    assert cloud.is_octree
    assert cloud.size == pytest.approx(0.1)
    assert np.allclose(sorted(cloud.points.tolist()), sorted(middles), atol=1e-6)
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[1, 2, 3]] * 3


@VERSIONS
def test_a_point_cloud_has_its_points(ser: int) -> None:
    points = np.random.default_rng(1).uniform(-3, 3, (200, 3))
    writer = VrepWriter(ser)
    writer.point_cloud("cloud", points.tolist(), (9, 8, 7))
    cloud = only(writer, PointCloud)
    assert not cloud.is_octree
    order, expected = np.lexsort(cloud.points.T), np.lexsort(points.T)
    assert np.allclose(cloud.points[order], points[expected], atol=1e-5)
    assert cloud.colors is not None
    assert cloud.colors.tolist() == [[9, 8, 7]] * 200


def test_cells_of_an_unknown_kind_are_noted() -> None:
    writer = VrepWriter(21)
    writer.other("OCT", "cells", chunk("Co2", b"\x03" + bytes(40)))
    file = read(writer)
    assert [note for note in file.notes if "unknown kind" in note]
    (cloud,) = file.objects.values()
    assert isinstance(cloud, PointCloud)
    assert not len(cloud.points)


@VERSIONS
def test_cameras_lights_graphs_and_mills_are_read(ser: int) -> None:
    writer = VrepWriter(ser)
    writer.camera("view", angle=0.5, near=0.2, far=50.0)
    writer.light("lamp", kind=2, color=(0.5, 0.25, 0.0), on=False)
    item = writer.dummy("item")
    writer.graph("plot", [("height", 3, item)])
    writer.mill("drill")
    camera, light, graph, mill = (only(writer, kind) for kind in (Camera, Light, Graph, OtherObject))
    assert isinstance(camera, Camera)
    assert (camera.angle, camera.near, camera.far, camera.is_perspective) == (
        0.5,
        pytest.approx(0.2),
        50,
        True,
    )
    assert isinstance(light, Light)
    assert (light.type, light.is_on) == (2, False)
    if ser >= 18:  # older files have no such colour
        assert light.color.light == (0.5, 0.25, 0.0)
    assert isinstance(graph, Graph)
    (stream,) = graph.streams
    assert (stream.name, stream.kind, stream.object) == ("height", 3, item)
    assert isinstance(mill, OtherObject)
    assert mill.volume is not None
    assert (mill.kind, mill.volume.type) == ("mill", "cylinder")


@VERSIONS
def test_a_model_has_pose_and_size(ser: int) -> None:
    writer = VrepWriter(ser, is_model=True)
    writer.dummy("base", model_base=True)
    writer.model_information((1, 2, 3), (0.5, 0.25, 2))
    file = read(writer)
    assert (file.is_model, file.model_pose[0], file.bounds) == (True, (1, 2, 3), (0.5, 0.25, 2))


def test_a_thumbnail_keeps_its_pixels() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (128, 128, 3))
    writer = VrepWriter(21)
    writer.thumbnail(pixels)
    found = read(writer).thumbnail
    assert found is not None
    assert (found == pixels).all()


def test_a_thumbnail_of_half_bytes_is_read() -> None:
    pixels = np.random.default_rng(0).integers(0, 16, (128, 128, 3))
    flat = pixels.reshape(-1)
    data = (flat[::2] | flat[1::2] << 4).astype(np.uint8).tobytes()
    writer = VrepWriter(21)
    writer.records.append(listed("MTC", chunk("Tm2", b"\1\1" + data)))
    found = read(writer).thumbnail
    assert found is not None
    assert (found == pixels * 17).all()


def test_records_that_are_not_read_are_counted() -> None:
    writer = VrepWriter(21)
    writer.records += [chunk("QQQ", b"EOO"), chunk("QQQ", b"EOO"), chunk("GHO", b"EOO")]
    assert read(writer).skipped == {"QQQ": 2}
