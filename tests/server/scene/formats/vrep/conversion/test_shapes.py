"""Shapes of V-REP files as bodies: what is seen, what collides, what sensors may do with them."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from vrep_concave import bowl
from vrep_meshes import mesh_of
from vrep_shapes import box_leaf, compiled, converted, cube, file_of, mesh_leaf, settled, shape_of

from simx_server.scene.formats.annotations import read_annotations
from simx_server.scene.formats.vrep.conversion import shapes as conversion_of_shapes
from simx_server.scene.formats.vrep.conversion.geometry.colliding import decomposition
from simx_server.scene.formats.vrep.conversion.shapes import HIDDEN, SEEN, UNDRAWN
from simx_server.scene.formats.vrep.objects import (
    Engine,
    Leaf,
    Primitive,
    Shape,
    Surface,
    Texture,
    TextureUse,
)
from simx_server.scene.poses.poses import NO_TURN, about

GEOM = mujoco.mjtGeom


def primitive(kind: Primitive, size: tuple[float, float, float], **parts: Any) -> Leaf:
    """A leaf of a file: a primitive with its mesh."""
    leaf = mesh_leaf(*mesh_of(kind.name.lower(), size), **parts)
    leaf.primitive, leaf.size = kind, size
    return leaf


def solid(*leaves: Leaf, **parts: Any) -> Shape:
    return shape_of(*leaves, is_respondable=True, **parts)


def groups(model: Any) -> list[int]:
    return model.geom_group.tolist()


def test_pure_shape_is_one_geom_that_is_seen_and_collides() -> None:
    model = compiled(file_of(solid(box_leaf())))
    assert groups(model) == [SEEN]
    assert (model.geom_contype[0], model.geom_conaffinity[0]) == (1, 1)
    assert compiled(file_of(shape_of(box_leaf()))).geom_contype[0] == 0


def test_leaves_of_a_compound_lie_at_their_poses() -> None:
    turn = about((0.0, 0.0, 1.0), math.pi / 2)
    leaves = [box_leaf(), box_leaf((0.1, 0.2, 0.3), pose=((1.0, 2.0, 3.0), turn))]
    model = compiled(file_of(solid(*leaves)))
    assert model.geom_pos[1] == pytest.approx([1, 2, 3])
    assert model.geom_quat[1] == pytest.approx(turn)
    assert model.geom_size[1] == pytest.approx([0.05, 0.1, 0.15])


@pytest.mark.parametrize("kind", [Primitive.CONE, Primitive.MESH])
def test_convex_mesh_is_one_geom_that_is_seen_and_collides(kind: Primitive) -> None:
    leaf = primitive(Primitive.CONE, (1.0, 1.0, 2.0))
    leaf.primitive = kind
    model = compiled(file_of(solid(leaf)))
    assert groups(model) == [SEEN]
    assert model.geom_contype[0] == 1
    assert model.mesh_graphadr[0] >= 0, "it has a hull"


@pytest.mark.parametrize("kind", [Primitive.PLANE, Primitive.DISC])
def test_planes_and_discs_are_seen_from_both_sides_and_carry_things(kind: Primitive) -> None:
    sheet = solid(primitive(kind, (2.0, 2.0, 0.0)), pose=((0.0, 0.0, 1.0), NO_TURN))
    ball = solid(
        Leaf(primitive=Primitive.SPHEROID, size=(0.2, 0.2, 0.2)),
        handle=2, is_dynamic=True, mass=1.0, inertia=(0.004, 0.004, 0.004), pose=((0.1, 0.2, 1.3), NO_TURN),
    )  # fmt: skip
    model = compiled(file_of(sheet, ball))
    assert groups(model) == [SEEN, HIDDEN, SEEN]
    assert model.geom_contype.tolist() == [0, 1, 1]
    normals = model.mesh_normal[: model.mesh_normalnum[0]]
    assert np.abs(normals.sum(axis=0)).max() < 1e-3, "as many points look up as down"
    assert settled(model).qpos[2] == pytest.approx(1.1, abs=2e-3)


def test_mesh_that_is_not_convex_collides_by_hidden_solids(monkeypatch: pytest.MonkeyPatch) -> None:
    points, faces = cube()
    two = mesh_leaf(np.concatenate([points, points + 3]), np.concatenate([faces, faces + 8]))
    for module in (decomposition, conversion_of_shapes):
        monkeypatch.setattr(module, "is_available", lambda: False)
    conversion = converted(file_of(solid(two)))
    model = conversion.spec.compile()
    assert groups(model) == [SEEN, HIDDEN, HIDDEN]
    assert model.geom_contype.tolist() == [0, 1, 1]
    assert not conversion.report.approximated
    moving = solid(mesh_leaf(*bowl()), is_dynamic=True, mass=1.0, inertia=(0.1, 0.1, 0.1))
    conversion = converted(file_of(moving))
    ((sentence, names),) = conversion.report.approximated.items()
    assert "convex hulls" in sentence
    assert "coacd" in sentence
    assert names == ["shape1"]


def test_textured_pure_shape_is_drawn_as_a_mesh_and_collides_as_a_box() -> None:
    pixels = np.zeros((2, 2, 3), np.uint8)
    leaf = box_leaf(texture=TextureUse(texture=4))
    model = compiled(file_of(solid(leaf), textures={4: Texture(id=4, pixels=pixels)}))
    assert model.geom_type.tolist() == [int(GEOM.mjGEOM_MESH), int(GEOM.mjGEOM_BOX)]
    assert groups(model) == [SEEN, HIDDEN]
    assert model.geom_contype.tolist() == [0, 1]


def test_angular_cylinder_is_drawn_as_in_vrep_and_rolls_as_a_cylinder() -> None:
    leaf = primitive(Primitive.CYLINDER, (1.0, 1.0, 1.0))
    angles = np.arange(6) * math.pi / 3
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) / 2
    leaf.vertices = np.concatenate([np.insert(ring, 2, z, axis=1) for z in (-0.5, 0.5)]).astype(np.float32)
    a = np.arange(6)
    b = (a + 1) % 6
    leaf.triangles = np.concatenate([np.stack([a, b, b + 6], 1), np.stack([a, b + 6, a + 6], 1)]).astype(
        np.int32
    )
    leaf.normals = None
    model = compiled(file_of(solid(leaf)))
    assert model.geom_type.tolist() == [int(GEOM.mjGEOM_MESH), int(GEOM.mjGEOM_CYLINDER)]


def hill() -> Leaf:
    """A height field of 5 x 9 points on 2 x 4 m, which rises along x and y, and its mesh."""
    y, x = np.meshgrid(np.linspace(-2, 2, 9), np.linspace(-1, 1, 5), indexing="ij")
    heights = 0.5 + 0.2 * x + 0.05 * y
    points = np.stack([x, y, heights], axis=2).reshape(-1, 3)
    cell = (np.arange(8)[:, np.newaxis] * 5 + np.arange(4)).ravel()
    faces = np.concatenate([np.stack([cell, cell + 1, cell + 6], 1), np.stack([cell, cell + 6, cell + 5], 1)])
    leaf = mesh_leaf(points, faces)
    leaf.primitive, leaf.size, leaf.heights = Primitive.HEIGHT_FIELD, (2.0, 4.0, 0.4), heights
    return leaf


def test_things_lie_on_a_height_field_where_it_is_drawn() -> None:
    for x, y in ((0.8, -1.5), (-0.7, 1.2)):
        ball = Shape(
            handle=2, name="ball", is_dynamic=True, is_respondable=True, mass=1.0, inertia=(0.004, 0.004, 0.004),
            leaves=[Leaf(primitive=Primitive.SPHEROID, size=(0.1, 0.1, 0.1))], pose=((x, y, 2.0), NO_TURN),
        )  # fmt: skip
        field = solid(hill(), pose=((0.0, 0.0, 0.3), NO_TURN))
        model = compiled(file_of(field, ball))
        assert groups(model) == [SEEN, HIDDEN, SEEN]
        model.opt.gravity[:] = 0
        data = mujoco.MjData(model)
        above = 0.3 + 0.5 + 0.2 * x + 0.05 * y
        for height, touches in ((above + 0.06, False), (above + 0.045, True)):
            data.qpos[2] = height
            mujoco.mj_forward(model, data)
            assert bool(data.ncon) is touches
        down, hit = np.array([0.0, 0.0, -1.0]), np.zeros(1, np.int32)
        seen = np.array([1, 0, 0, 0, 0, 0], np.uint8)
        ray = mujoco.mj_ray(model, data, np.array([x, y, 5.0]), down, seen, 1, 2, hit, None)
        assert 5.0 - ray == pytest.approx(above, abs=1e-5)


def test_level_and_damaged_height_fields_are_harmless() -> None:
    level = hill()
    level.vertices = level.vertices * np.array([1, 1, 0], np.float32)
    level.heights = np.zeros((9, 5))
    assert compiled(file_of(solid(level))).nhfield == 1
    broken = hill()
    broken.heights = None
    conversion = converted(file_of(solid(broken)))
    assert conversion.spec.compile().nhfield == 0
    assert conversion.report.left_out


def test_equal_meshes_are_stored_once() -> None:
    cone = primitive(Primitive.CONE, (1.0, 1.0, 2.0))
    shapes = [solid(primitive(Primitive.CONE, (1.0, 1.0, 2.0)), handle=handle) for handle in range(1, 6)]
    shapes.append(solid(primitive(Primitive.CONE, (1.0, 1.0, 2.5)), handle=9))
    model = compiled(file_of(*shapes))
    assert model.ngeom == 6
    assert model.nmesh == 2
    assert len(cone.vertices)


def test_shape_of_lines_is_a_shape_that_images_do_not_show_and_sensors_detect() -> None:
    frame = shape_of(box_leaf(is_wireframe=True), name="frame")
    floor = shape_of(box_leaf(), box_leaf(is_wireframe=True), handle=2, name="floor")
    conversion = converted(file_of(frame, floor))
    conversion.write_notes()
    model = conversion.spec.compile()
    assert groups(model) == [UNDRAWN, SEEN]
    assert list(conversion.report.left_out.values()) == [["frame"]]
    notes = read_annotations(conversion.spec).objects
    assert str(notes["frame"]["shape"]["detectable"]).count(",") == 4
    assert "detectable" not in notes["floor"]["shape"]


@pytest.mark.parametrize(
    "leaf",
    [
        Leaf(),
        mesh_leaf([[0, 0, 0], [1e-9, 0, 0], [0, 1e-9, 0]], [[0, 1, 2]]),
        mesh_leaf([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], normals=np.zeros((1, 3, 3), np.float32)),
        Leaf(primitive=Primitive.CUBOID, size=(math.nan, 1, 1)),
    ],
)
def test_shape_without_a_form_stays_a_shape_and_is_reported(leaf: Leaf) -> None:
    conversion = converted(file_of(solid(leaf)))
    model = conversion.spec.compile()
    assert model.ngeom == 1
    assert groups(model) == [HIDDEN]
    assert conversion.report.left_out


@pytest.mark.parametrize("corners", [3, 4])
def test_single_triangle_and_thin_sheet_are_shown_and_collide(corners: int) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 1e-6]], np.float32)[:corners]
    faces = np.array([[0, 1, 2], [1, 3, 2]], np.int32)[: corners - 2]
    assert groups(compiled(file_of(solid(mesh_leaf(points, faces))))) == [SEEN, HIDDEN]


def test_annotations_say_what_sensors_and_programs_may_do() -> None:
    shape = Shape(
        handle=1, name="thing", leaves=[box_leaf()], properties=0x20 | 0x2, mask=0xFF0F,
        first_velocity=(0.5, 0.0, 0.0, 0.0, 0.0, -2.0),
    )  # fmt: skip
    conversion = converted(file_of(shape))
    conversion.write_notes()
    note = read_annotations(conversion.spec).objects["thing"]["shape"]
    assert note == {
        "renderable": False,
        "detectable": "infrared",
        "collidable": False,
        "mask": 0xFF0F,
        "first_velocity": "0.5,0.0,0.0,0.0,0.0,-2.0",
    }


def test_numbers_that_are_none_are_not_annotated() -> None:
    conversion = converted(file_of(shape_of(box_leaf(), first_velocity=(math.nan,) + (0.0,) * 5)))
    assert "first_velocity" not in conversion.notes["shape", "shape1"]


def test_report_names_what_the_physics_and_the_look_lack() -> None:
    damped = Surface(engines={Engine.BULLET: ([0.0, 1.0, 1.0, 0.1, 0.0], [])})
    once = TextureUse(texture=4, scale=(0.3, 1.0), flags=1 | 8)
    pixels = np.zeros((2, 2, 3), np.uint8)
    slow = shape_of(box_leaf(texture=once), is_dynamic=True, is_asleep=True, surface=damped)
    fixed = shape_of(box_leaf(texture=TextureUse(texture=4, flags=1)), handle=2, surface=damped)
    report = converted(file_of(slow, fixed, textures={4: Texture(id=4, pixels=pixels)})).report
    assert list(report.left_out.values()) == [["shape1"]]
    assert {tuple(names) for names in report.approximated.values()} >= {("shape1",)}
    assert any("repeated" in sentence for sentence in report.approximated)
    assert any("asleep" in sentence for sentence in report.approximated)
    assert not any("shape2" in names for names in report.approximated.values())
