"""Methods of API 2: what they return, and that they do what API 1's functions do."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from model_world import Model, model

from simx_server.errors import CommandError
from simx_server.sim_api.object_model.classes import class_of
from simx_server.sim_api.object_model.values import Color, Matrix, Pose, Quaternion, Ref

__all__ = ["model"]


def made(model: Model, **fields: Any) -> Ref:
    return model.do("scene", "createObject", {key.replace("__", "."): value for key, value in fields.items()})


def test_objects_are_found_by_paths_with_and_without_a_slash(model: Model) -> None:
    assert model.at("cube") == model.at("/cube")
    assert model.do("/robot", "getObject", "hinge/arm") == (model.at("/robot/hinge/arm"),)
    assert model.do("/robot", "getObject", "./hinge") == (model.at("/robot/hinge"),)
    assert model.do("scene", "getObject", "/nothing", {"noError": True}) == (None,)
    with pytest.raises(CommandError, match="no object named"):
        model.at("/nothing")


def test_objects_are_listed_by_class_and_depth(model: Model) -> None:
    joints = model.do("scene", "getObjects", ["joint"])
    assert joints == [model.at("/robot/hinge")]
    assert model.at("/robot/hinge/arm/tip") in model.do("/robot", "getDescendants")
    assert model.at("/robot/hinge/arm/tip") not in model.do("/robot", "getDescendants", {"depth": 2})
    assert model.do("/robot/hinge/arm", "getAncestors") == [model.at("/robot/hinge"), model.at("/robot")]
    with pytest.raises(CommandError, match="no class of scene objects"):
        model.do("scene", "getObjects", ["cuboid"])


def test_poses_are_in_the_world_or_relative_to_an_object(model: Model) -> None:
    tip = model.at("/robot/hinge/arm/tip")
    assert model.do(tip, "getPosition").numbers == pytest.approx([0.4, 0, 1.3])
    relative = model.do(tip, "getPose", {"relativeToObject": model.at("/robot")})
    assert isinstance(relative, Pose)
    assert relative.numbers[:3] == pytest.approx([0.4, 0, 0.3])
    model.do("/cube", "setPose", Pose([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), {"relativeToObject": tip})
    assert model.do("/cube", "getPosition").numbers == pytest.approx([1.4, 0, 1.3])
    model.do("/cube", "setPosition", Matrix.vector([0, 0, 5]))
    model.do("/cube", "setQuaternion", Quaternion([0.0, 0.0, 1.0, 0.0]))
    assert model.do("/cube", "getQuaternion") == Quaternion([0.0, 0.0, 1.0, 0.0])


def test_a_parent_is_changed_in_the_world_or_in_the_frame(model: Model) -> None:
    model.do("/robot/mark", "setParent", model.at("/wall"))
    assert model.get("/wall/mark", "worldPosition").numbers == pytest.approx([0.1, 0.2, 1.3])
    model.do("/wall/mark", "setParent", None, {"mode": "keepLocalPose"})
    assert model.get("/mark", "parent") == Ref(-1)
    with pytest.raises(CommandError, match="assembly"):
        model.do("/mark", "setParent", model.at("/wall"), {"mode": "assembly"})


def test_names_have_forms(model: Model) -> None:
    assert model.do("/robot/hinge", "getName") == "hinge"
    assert model.do("/robot/hinge/arm", "getName", "fullPath") == "/robot/hinge/arm"
    with pytest.raises(CommandError, match="no form of a name"):
        model.do("/cube", "getName", "long")


FORMS: list[tuple[dict[str, Any], int]] = [
    ({"cuboid": {"size": [0.2, 0.3, 0.4]}}, 3),
    ({"spheroid": {"radius": 0.1}}, 4),
    ({"cylinder": {"radius": 0.1, "length": 0.3}}, 5),
    ({"cone": {"radius": 0.1, "height": 0.3}}, 6),
    ({"capsule": {"radius": 0.1, "length": 0.4}}, 8),
    ({"plane": {"size": [1, 1]}}, 1),
    ({"disc": {"radius": 0.2}}, 2),
]


@pytest.mark.parametrize("fields", [form for form, _ in FORMS])
def test_shapes_are_created_with_their_properties(model: Model, fields: dict[str, Any]) -> None:
    new = model.do(
        "scene",
        "createObject",
        {"type": "shape", **fields, "name": "new", "color.diffuse": [1.0, 0.0, 0.0], "dynamic": True},
    )
    assert model.get(new, "name") == "new"
    assert model.get(new, "type") == "shape"
    assert model.get(new, "color.diffuse") == Color(b"\xff\x00\x00\xff")


def test_meshes_take_points_as_columns(model: Model) -> None:
    corners = Matrix(3, 4, [0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
    faces = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
    new = made(model, type="shape", mesh={"vertices": corners, "indices": faces})
    assert model.get(new, "vertices").rows == 3
    field = made(model, type="shape", heightField={"heights": [[0, 1, 0], [0, 0, 0.5]], "cellSize": 0.5})
    assert model.get(field, "type") == "shape"


@pytest.mark.parametrize(
    ("fields", "name", "value"),
    [
        ({"type": "dummy", "size": 0.02}, "type", "dummy"),
        ({"type": "joint", "joint.type": "prismatic", "bounds": [-1.0, 1.0]}, "joint.type", "prismatic"),
        ({"type": "forceSensor"}, "filter", 0),
        ({"type": "visionSensor", "resolution": [32, 16]}, "resolution", [32, 16]),
        ({"type": "visionSensor", "viewSize": 2.0}, "perspective", False),
        (
            {"type": "proximitySensor", "proximitySensor.type": "ray", "volume.range": 0.5},
            "volume.range",
            0.5,
        ),
        ({"type": "pointCloud", "cellSize": 0.05}, "cellSize", 0.05),
        ({"type": "ocTree", "voxelSize": 0.05}, "voxelSize", 0.05),
        ({"type": "marker", "marker.type": "cubes"}, "marker.type", "cubes"),
        ({"type": "collection"}, "objects", []),
        ({"type": "graph"}, "bufferSize", 1000),
    ],
)
def test_objects_of_every_type_are_created(
    model: Model, fields: dict[str, Any], name: str, value: Any
) -> None:
    new = model.do("scene", "createObject", dict(fields))
    assert model.get(new, name) == value
    assert class_of(model.parts, new.handle, model.script) == fields["type"]
    model.do(new, "remove")
    assert not model.do(new, "isValid")


def test_a_wrong_property_of_a_new_object_leaves_nothing_behind(model: Model) -> None:
    before = model.get("scene", "objects")
    with pytest.raises(CommandError, match="property"):
        made(model, type="dummy", nonsense=1)
    assert model.get("scene", "objects") == before
    for fields, text in (
        ({}, "unsupported object type"),
        ({"type": "test"}, "unknown type: test.*; valid: .*dummy"),
        ({"type": "camera"}, "cannot be made"),
        ({"type": "shape", "cuboid": {}, "color.diffuse": "blue"}, "colour"),
    ):
        with pytest.raises(CommandError, match=text):
            model.do("app", "createObject", fields)
    assert model.get("scene", "objects") == before


def test_settings_of_a_new_shape_are_kept(model: Model) -> None:
    shape = made(model, type="shape", cuboid={}, culling=True, showEdges=True, shadingAngle=0.5)
    assert [model.get(shape, name) for name in ("culling", "showEdges", "shadingAngle")] == [True, True, 0.5]


def test_markers_keep_points_and_remove_items(model: Model) -> None:
    marker = made(model, type="marker", marker__type="spheres", itemSize=[0.1, 0.1, 0.1])
    points = Matrix(3, 2, [1.0, 4.0, 2.0, 5.0, 3.0, 6.0])
    colors = Matrix(4, 2, [1, 0, 0, 1, 0, 0, 1, 1])
    assert model.do(marker, "addItems", points, {"colors": colors}) == [0, 1]
    assert model.get(marker, "points") == points
    model.do(marker, "removeItems", [0])
    assert model.get(marker, "points").numbers == [4.0, 5.0, 6.0]
    assert marker in model.get("scene", "drawingObjects")
    model.do(marker, "clearItems")
    assert model.get(marker, "points").columns == 0


def test_clouds_take_points_as_columns_and_packed(model: Model) -> None:
    cloud = made(model, type="pointCloud")
    model.do(cloud, "addPoints", Matrix(3, 2, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]), {"color": [1.0, 0.0, 0.0]})
    model.do(cloud, "addPackedPoints", struct.pack("<3d", 2, 0, 0))
    assert model.get(cloud, "points").columns == 3
    model.do(cloud, "subtractPoints", [[2.0], [0.0], [0.0]], {"tolerance": 0.1})
    assert model.get(cloud, "points").columns == 2
    model.do(cloud, "intersectPoints", Matrix(3, 1, [1.0, 0.0, 0.0]), {"tolerance": 0.1})
    assert len(model.get(cloud, "packedPoints")) == 24
    model.do(cloud, "clear")
    tree = made(model, type="ocTree", voxelSize=0.1)
    model.do(tree, "addVoxels", Matrix(3, 1, [0.55, 0.0, 0.0]), {"tag": 7})
    assert model.do(tree, "checkPoints", Matrix(3, 1, [0.55, 0.0, 0.0]))[:2] == (True, 7)
    model.do(tree, "addFromObjects", [model.at("/cube")])
    assert len(model.get(tree, "colors")) == model.get(tree, "points").columns * 3
    model.do(tree, "subtractFromObjects", [model.at("/cube")])
    assert model.get(tree, "points").columns == 1


def test_collisions_distances_and_collections(model: Model) -> None:
    near, distance, first, second, pair = model.do("/cube", "checkDistance", model.at("/cube#0"))
    assert (near, distance, pair) == (True, pytest.approx(0.8), [model.at("/cube"), model.at("/cube#0")])
    assert second.numbers[0] - first.numbers[0] == pytest.approx(0.8)
    assert model.do("/cube", "checkCollision", model.at("/wall")) == (False, [Ref(-1), Ref(-1)])
    group = made(model, type="collection")
    model.do(group, "addItem", model.at("/cube"))
    assert model.get(group, "objects") == [model.at("/cube")]
    assert group in model.get("scene", "collections")
    assert model.do("/cube#0", "checkDistance", group, {"threshold": 0.5})[0] is False
    before = model.do(group, "changeColor", [0.0, 1.0, 0.0])
    assert model.get("/cube", "color.diffuse") == Color(b"\x00\xff\x00\xff")
    model.do(group, "restoreColor", before)
    assert model.get("/cube", "color.diffuse") != Color(b"\x00\xff\x00\xff")


def test_a_force_moves_a_shape_and_its_inertia_is_returned(model: Model) -> None:
    inertia, centre = model.do("/cube", "getInertia")
    assert (inertia.rows, centre.numbers) == (3, pytest.approx([0, 0, 0]))
    model.do("/cube", "setInertia", inertia, Pose([0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))
    assert model.get("/cube", "centerOfMass").numbers == pytest.approx([0.01, 0, 0])
    model.do("/cube", "computeInertia", 1000.0)
    assert model.get("/cube", "mass") == pytest.approx(8.0)
    model.run()
    model.do("/cube", "addForce", Matrix.vector([0, 80, 0]), {"relative": True})
    model.parts.step()
    assert model.get("/cube", "linearVelocity").numbers[1] > 0.1


def test_sensors_return_bools_and_objects(model: Model) -> None:
    found = model.do("/ray", "handleSensor")
    assert found[0] is True
    assert found[3] == model.at("/wall")
    assert model.do("/ray", "checkSensor", model.at("/cube"))[0] is False
    model.do("/ray", "resetSensor")


def test_the_simulation_is_started_and_stopped(model: Model) -> None:
    model.do("scene", "simulation.start")
    model.do("scene", "simulation.stop")
    with pytest.raises(
        CommandError, match=r"no method of class scene is called .simulation[.]strat.; did you mean"
    ):
        model.do("scene", "simulation.strat")
    with pytest.raises(CommandError, match="not available for this object type, joint; it is one of shape"):
        model.do("/robot/hinge", "addForce", [1.0, 0.0, 0.0])


def test_values_are_packed_and_unpacked(model: Model) -> None:
    for value in (Matrix.vector([1, 2, 3]), {"a": [1, "b"]}, Ref(16), None, 5):
        for pack, unpack in (("pack", "unpack"), ("serialize", "deserialize")):
            assert model.do("app", unpack, model.do("app", pack, value)) == (value,)
    packed = model.do("app", "packArray", [1, 2, 3], {"type": "int16", "start": 1})
    assert packed == b"\2\0\3\0"
    assert model.do("app", "unpackArray", packed, {"type": "int16"}) == [2, 3]
    assert model.do("app", "getEnumInfo", "jointType") == {"revolute": 10, "prismatic": 11, "spherical": 12}


def test_images_are_converted(model: Model) -> None:
    image = bytes(range(12))
    content = model.do("app", "saveImageToBuffer", image, [2, 2])
    assert model.do("app", "loadImageFromBuffer", content) == (image, [2, 2], 3)
    flipped, size, channels = model.do(
        "app", "transformImage", image, [2, 2], [2, 2], {"flipAxisX": True, "smooth": False}
    )
    assert (flipped[:6], size, channels) == (bytes([3, 4, 5, 0, 1, 2]), [2, 2], 3)
    assert model.do("app", "transformBuffer", b"\1\2", 0, 2, {"scale": 2.0}) == b"\2\0\4\0"


def test_objects_are_copied_grouped_and_removed(model: Model) -> None:
    (copy,) = model.do("scene", "duplicateObjects", [model.at("/cube")])
    assert model.get(copy, "type") == "shape"
    model.do("scene", "removeObjects", [copy])
    assert not model.do(copy, "isValid")
    first, second = (made(model, type="shape", cuboid={}) for _ in range(2))
    compound = model.do("scene", "groupShapes", [first, second])
    assert model.get(compound, "compound")
    assert len(model.do(compound, "ungroup")) == 2


def test_code_and_compiled_methods_are_refused(model: Model) -> None:
    with pytest.raises(CommandError, match="compiled code"):
        model.do("/cube", "setMethodProperty", "customData.run", b"\x1bLua")


@pytest.mark.parametrize(
    ("target", "name", "arguments", "text"),
    [
        ("/cube", "checkDistance", [-2, {"threshold": float("nan")}], "threshold"),
        ("/cube", "addForce", [[1.0, 0.0, 0.0], {"offset": [1.0]}], "offset"),
        ("/cube", "setPosition", [[1.0, 2.0]], "3"),
        ("/cube", "setPose", [[float("inf")] * 7], "finite|table"),
        ("scene", "getContacts", [{"dynPass": 1 << 40}], "32 bits"),
        ("scene", "createObject", [{"type": "dummy", "size": float("inf")}], "size"),
        ("scene", "createObject", [{"type": "visionSensor", "resolution": [1]}], "two whole numbers"),
        ("scene", "createObject", [{"type": "marker", "itemSize": []}], "not empty"),
        ("scene", "createObject", [{"type": "marker", "parent": [1]}], "parent"),
        ("scene", "getObject", ["/cube", {"index": [1]}], "index"),
        ("app", "getObjects", [{"types": 5}], "types"),
        ("/robot", "getDescendants", [{"types": 5}], "types"),
        ("/cube", "getProperty", ["position", {"type": [5]}], "type"),
        ("/cube", "getProperty", ["position", {"type": float("inf")}], "type"),
        ("/cube", "setProperty", ["color.diffuse", "blue"], "red, green, blue"),
        ("/cube", "setProperty", ["customData.map", {"a": 1 << 2000}], "too large"),
        ("app", "pack", [{"a": 1 << 2000}], "too large"),
        ("app", "unpackArray", [bytes(2_000_000), {"type": "int8"}], "at most"),
        ("app", "transformImage", [b"12345", [2, 2], [2, 2]], "no image"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(
    model: Model, target: str, name: str, arguments: list[Any], text: str
) -> None:
    with pytest.raises(CommandError, match=text):
        model.do(target, name, *arguments)


GRAPH = """
<mujoco>
  <worldbody><site name="plot"/></worldbody>
  <custom><text name="simx:object:plot" data="type=graph"/></custom>
</mujoco>
"""


def test_graphs_record_signals_and_copy_curves(tmp_path: Path) -> None:
    model = Model(GRAPH, workspace=tmp_path)
    signal = model.do("/plot", "addSignal", {"name": "x", "transformation": {"type": "raw", "scale": 2.0}})
    curve = model.do("/plot", "addCurve", [signal, signal], {"name": "both", "color": [1.0, 0.0, 0.0]})
    for time in (0.1, 0.2):
        model.do("/plot", "setSignalPoint", signal, 10 * time)
        model.do("/plot", "step", time)
    assert model.do("/plot", "snapshotTrace", curve) != curve
    model.do("/plot", "removeTrace", curve)
    model.do("/plot", "reset")
    with pytest.raises(CommandError, match="no transformation"):
        model.do("/plot", "addSignal", {"transformation": {"type": "square"}})
