"""Colours and textures of leaves as materials and textures."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from vrep_shapes import box_leaf, converted, cube, file_of, mesh_leaf, shape_of

from simx_server.scene.formats.vrep.objects import (
    Leaf,
    Material,
    Texture,
    TextureUse,
    VisionSensor,
)
from simx_server.scene.geometry.highlights import highlights_of

RGB = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
PIXELS = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 9, 9]], [[1, 2, 3], [4, 5, 6]]], np.uint8)


def model_of(*leaves: Leaf, textures: Any = None, others: Any = ()) -> tuple[Any, Any]:
    conversion = converted(file_of(shape_of(*leaves), *others, textures=textures or {}))
    return conversion.spec.compile(), conversion.report


def test_leaves_of_one_look_share_a_material_that_has_the_name_of_the_colour() -> None:
    blue = Material(name="UR5 BLUE", diffuse=(0.1, 0.2, 0.9), opacity=0.5)
    model, _ = model_of(box_leaf(material=blue), box_leaf(material=blue), box_leaf())
    assert model.nmat == 2
    assert model.geom_matid.tolist() == [0, 0, 1]
    assert model.mat_rgba[0] == pytest.approx([0.1, 0.2, 0.9, 0.5])
    assert model.material(0).name == "UR5_BLUE"


def test_highlights_have_a_strength_a_size_and_a_colour_that_is_not_grey() -> None:
    gold, grey = Material(specular=(0.2, 0.4, 0.6)), Material(specular=(0.3, 0.3, 0.3), shininess=100)
    leaves = box_leaf(material=gold), mesh_leaf(*cube(), material=gold), box_leaf(material=grey)
    model, _ = model_of(*leaves)
    assert model.geom_matid.tolist() == [0, 0, 1]
    assert model.mat_specular == pytest.approx([0.4, 0.3])
    assert model.mat_shininess == pytest.approx([48 / 128, 100 / 128])
    colors = highlights_of(model)
    assert list(colors) == [0]
    assert colors[0] == pytest.approx([0.2, 0.4, 0.6])


@pytest.mark.parametrize(
    ("diffuse", "emission", "rgb", "strength"),
    [
        ((0.8, 0.4, 0.4), (0.4, 0.2, 0.2), (0.8, 0.4, 0.4), 0.5),
        ((0.0, 0.0, 0.0), (1.0, 0.5, 0.0), (1.0, 0.5, 0.0), 1.0),
        ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0),
        ((2.0, -1.0, 0.5), (0.0, 0.0, 0.0), (1.0, 0.0, 0.5), 0.0),
    ],
)
def test_emission_is_a_share_of_the_colour(diffuse: Any, emission: Any, rgb: Any, strength: float) -> None:
    model, _ = model_of(box_leaf(material=Material(diffuse=diffuse, emission=emission)))
    assert model.mat_rgba[0, :3] == pytest.approx(rgb)
    assert model.mat_emission[0] == pytest.approx(strength)


def test_texture_keeps_its_rows_and_the_mesh_its_coordinates() -> None:
    """The first row of V-REP's pixels lies at v = 0; so does that of MuJoCo's."""
    leaf = box_leaf(texture=TextureUse(texture=7, scale=(2.0, 2.0)))
    model, _ = model_of(leaf, textures={7: Texture(id=7, pixels=PIXELS)})
    assert model.mat_texid[model.geom_matid[0], RGB] == 0
    assert model.tex_data.reshape(3, 2, 3).tolist() == PIXELS.tolist()
    assert model.geom_type[0] == mujoco.mjtGeom.mjGEOM_MESH
    up = np.abs(model.mesh_normal[:, 2]) > 0.9
    points = model.mesh_vert @ turned(model).T
    texcoord = model.mesh_texcoord
    assert np.allclose(texcoord[up], points[up, :2] / 2 + 0.5, atol=1e-6)


def turned(model: Any) -> np.ndarray:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, model.mesh_quat[0])
    return matrix.reshape(3, 3)


def test_one_texture_serves_many_leaves_and_survives_as_text() -> None:
    leaves = [box_leaf(texture=TextureUse(texture=7)), box_leaf(texture=TextureUse(texture=7, mode=3))]
    conversion = converted(file_of(shape_of(*leaves), textures={7: Texture(id=7, pixels=PIXELS)}))
    spec: Any = conversion.spec
    spec.compile()
    assert len(spec.textures) == 1
    again = mujoco.MjSpec.from_string(spec.to_xml(), assets=dict(spec.assets)).compile()
    assert again.tex_data.tolist() == spec.compile().tex_data.tolist()
    assert np.allclose(again.mesh_texcoord, spec.compile().mesh_texcoord, atol=1e-5)


def test_decal_is_not_changed_by_light() -> None:
    decal = TextureUse(texture=7, flags=2 | 1)
    model, report = model_of(
        box_leaf(texture=decal, material=Material(diffuse=(0.2, 0.2, 0.2))),
        textures={7: Texture(id=7, pixels=PIXELS)},
    )
    assert model.mat_rgba[0] == pytest.approx([1, 1, 1, 1])
    assert model.mat_emission[0] == 1.0
    assert not report.approximated


def test_report_names_the_shapes_whose_texture_is_missing_and_why() -> None:
    sensor = VisionSensor(handle=5, name="eye")
    leaves = [box_leaf(texture=TextureUse(texture=number)) for number in (5, 6, 7)]
    empty = Texture(id=7, pixels=np.zeros((0, 0, 3), np.uint8))
    model, report = model_of(*leaves, textures={7: empty}, others=[sensor])
    assert model.ntex == 0
    assert model.geom_type.tolist() == [int(mujoco.mjtGeom.mjGEOM_BOX)] * 3
    assert len(report.left_out) == 3
    assert all(names == ["shape1"] for names in report.left_out.values())
    assert any("vision sensor" in sentence for sentence in report.left_out)


def test_huge_textures_are_made_smaller() -> None:
    pixels = np.zeros((2, 8192, 3), np.uint8)
    model, _ = model_of(box_leaf(texture=TextureUse(texture=7)), textures={7: Texture(id=7, pixels=pixels)})
    assert model.tex_width[0] == 4096
