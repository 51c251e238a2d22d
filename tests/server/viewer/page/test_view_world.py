"""The scene as the browser gets it: shapes, colours and places of bodies, and what is drawn beside them."""

from __future__ import annotations

from typing import Any, cast

import mujoco
import numpy as np
import pytest
from PIL import Image

pytest.importorskip("viser", reason="needs the extra viewer")

import trimesh
import viser
from browser_panels import browser
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from simx_server.viewer.messages import Drawing, SceneItem
from simx_server.viewer.page.mirror import Copy, Mirror
from simx_server.viewer.page.tools.gizmo import Gizmo
from simx_server.viewer.page.view.bodies import Body
from simx_server.viewer.page.view.drawings import Drawings
from simx_server.viewer.page.view.geoms import appearance, meshes_of
from simx_server.viewer.page.view.selected import Selected
from simx_server.viewer.page.view.smoothing import smoothed
from simx_server.viewer.page.view.tones import albedo
from simx_server.viewer.page.view.world import World, contact_forces

pytestmark = pytest.mark.slow

__all__ = ["browser"]

SCENE = """
<mujoco>
  <asset>
    <texture name="checks" type="2d" builtin="checker" rgb1="1 0 0" rgb2="0 0 1" width="20" height="10"/>
    <material name="paper" texture="checks" texrepeat="4 2"/>
    <material name="blue" rgba="0 0 1 1"/>
  </asset>
  <worldbody>
    <geom name="floor" type="plane" size="2 1 0.1" material="paper"/>
    <body name="cube" pos="0 0 0.095">
      <freejoint/>
      <geom name="own" type="box" size="0.1 0.1 0.1" material="blue" rgba="0 1 0 1" mass="2"/>
      <geom name="of_material" type="sphere" size="0.05" pos="0 0 0.3" material="blue" mass="0"/>
      <geom name="collides_only" type="box" size="1 1 1" group="3" contype="0" conaffinity="0" mass="0"/>
      <geom name="invisible" type="box" size="1 1 1" rgba="1 1 1 0" contype="0" conaffinity="0" mass="0"/>
    </body>
    <body name="nothing_to_see"><site name="mark"/></body>
  </worldbody>
</mujoco>
"""


def material_of(mesh: trimesh.Trimesh) -> Any:
    return cast(Any, mesh.visual).material


def factor(mesh: trimesh.Trimesh) -> list[float]:
    """The linear colour of a mesh, red, green and blue."""
    return (np.array(material_of(mesh).baseColorFactor[:3]) / 255).tolist()


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(SCENE)


def test_round_bodies_are_sent_with_normals_and_keep_their_edges() -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom type='cylinder' size='0.1 0.2'/></worldbody></mujoco>"
    )
    (mesh,) = meshes_of(model, 0)
    around = np.abs(mesh.vertex_normals[:, 2])
    assert set(around.round(3)) == {0.0, 1.0}, "the side is round, its edge to the ends is sharp"
    side = mesh.vertex_normals[around < 0.5]
    assert side[:, :2] == pytest.approx(mesh.vertices[around < 0.5][:, :2] / 0.1, abs=1e-3)


def test_bodies_have_the_colours_that_mujoco_draws_and_nothing_hidden(model: mujoco.MjModel) -> None:
    own, of_material = meshes_of(model, model.body("cube").id)
    assert np.abs(own.bounds).max() == pytest.approx(0.1)  # neither of the big boxes
    assert np.abs(of_material.bounds).max() == pytest.approx(0.35)  # the sphere's top
    assert factor(own) == pytest.approx(albedo(np.array([0.0, 1.0, 0.0])), abs=0.005)
    assert factor(of_material) == pytest.approx(albedo(np.array([0.0, 0.0, 1.0])), abs=0.005)
    assert material_of(own).metallicFactor == 0.0  # ambient light does not reach a metal
    assert model.geom("own").matid[0] == model.material("blue").id  # the model is as it was
    assert list(meshes_of(model, model.body("nothing_to_see").id)) == []


def test_plane_has_its_pattern_as_often_as_the_material_says(model: mujoco.MjModel) -> None:
    (mesh,) = meshes_of(model, 0)
    assert np.allclose(mesh.bounds, [[-2, -1, 0], [2, 1, 0]])
    assert isinstance(mesh.visual, TextureVisuals)
    assert isinstance(mesh.visual.material, PBRMaterial)
    assert mesh.visual.uv is not None
    assert mesh.visual.uv.max(axis=0).tolist() == [4, 2]
    pixels = np.asarray(mesh.visual.material.baseColorTexture)
    assert pixels.shape == (10, 20, 3)
    red, green, blue = pixels[-1, 0].tolist()  # MuJoCo's first row is the lowest
    assert red > 10 * max(green, blue)


def test_appearance_changes_with_what_a_body_is_made_of_and_not_with_its_place(model: mujoco.MjModel) -> None:
    cube = model.body("cube").id
    before = appearance(model, cube), appearance(model, 0)
    model.body_pos[cube] += 1
    assert (appearance(model, cube), appearance(model, 0)) == before
    model.body_pos[cube] -= 1
    model.mat_rgba[model.material("blue").id] = (0, 0.5, 1, 1)
    assert appearance(model, cube) != before[0]
    assert appearance(model, 0) == before[1]
    model.mat_rgba[model.material("blue").id] = (0, 0, 1, 1)


def test_body_is_moved_and_gets_a_box_when_it_is_selected(
    model: mujoco.MjModel, browser: viser.ViserServer
) -> None:
    number = model.body("cube").id
    body = Body(browser.scene, number, list(meshes_of(model, number)))
    body.move(np.array([1.0, 2.0, 3.0]), np.array([0.0, 1.0, 0.0, 0.0]))
    frame = browser.scene._handle_from_node_name[f"/scene/body_{number}"]
    assert np.allclose(frame.position, [1, 2, 3])
    marked = f"/scene/body_{number}/selected"
    for is_selected in (True, True, False):
        body.mark(is_selected)
        assert (marked in browser.scene._handle_from_node_name) == is_selected
    body.remove()


def test_contact_forces_carry_the_weight(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    arrows = contact_forces(Copy(model, data))
    assert len(arrows) == 4
    force = (arrows[:, 1] - arrows[:, 0]).sum(axis=0) * 100  # 1 cm for each newton
    assert force == pytest.approx([0, 0, 2 * 9.81], abs=0.1)


def test_contact_forces_that_stay_are_sent_once(browser: viser.ViserServer) -> None:
    world = World(browser, cast(Any, None), Mirror(), Gizmo(browser, cast(Any, None)), lambda _: None)
    world._show_forces.value = True
    model = mujoco.MjModel.from_xml_string(SCENE)
    copy = Copy(model, mujoco.MjData(model))
    world._show_contacts(copy)
    shown = world._forces
    assert shown is not None
    world._show_contacts(copy)
    assert world._forces is shown
    copy.data.qpos[2] = 5.0
    world._show_contacts(copy)
    assert world._forces is None


def test_selected_objects_get_axes_where_they_are(model: mujoco.MjModel, browser: viser.ViserServer) -> None:
    data = mujoco.MjData(model)
    data.qpos[:3] = (1, 2, 3)
    mujoco.mj_kinematics(model, data)
    selected = Selected(browser.scene)
    items = [
        {"handle": 7, "name": "cube", "element": "body", "id": model.body("cube").id},
        {"handle": 8, "name": "mark", "element": "site", "id": model.site("mark").id},
    ]
    selected.choose(cast(list[SceneItem], items), 2.0)
    selected.move(Copy(model, data))
    nodes = browser.scene._handle_from_node_name
    assert np.allclose(nodes["/selected/7"].position, [1, 2, 3])
    assert np.allclose(nodes["/selected/8"].position, [0, 0, 0])
    selected.choose([], 2.0)
    assert "/selected/7" not in nodes


@pytest.mark.parametrize(
    ("flags", "points", "items", "kind"),
    [
        (0, 1, [[0, 0, 0], [1, 0, 0]], viser.PointCloudHandle),
        (1, 2, [[0, 0, 0, 1, 0, 0]], viser.LineSegmentsHandle),
        (2, 3, [[0, 0, 0, 1, 0, 0, 0, 1, 0]], viser.MeshHandle),
        (7, 1, [[0, 0, 0]], viser.PointCloudHandle),
        (8 | 0x1000, 1, [[0, 0, 0], [1, 0, 0], [1, 1, 0]], viser.LineSegmentsHandle),
    ],
)
def test_drawing_objects_are_shown_as_what_they_are(
    browser: viser.ViserServer, flags: int, points: int, items: list[list[float]], kind: type
) -> None:
    drawings = Drawings(browser.scene)
    drawing = {"handle": 1, "flags": flags, "size": 2.0, "color": (1, 0, 0), "points": points, "items": items}
    drawings.update([cast(Drawing, drawing)])
    assert isinstance(browser.scene._handle_from_node_name["/drawings/1"], kind)
    drawings.frame.visible = False
    drawings.update([])
    assert "/drawings/1" not in browser.scene._handle_from_node_name
    assert not drawings.frame.visible


def test_a_textured_mesh_of_many_parts_gets_normals_and_keeps_its_texture() -> None:
    corners = trimesh.creation.box().triangles.reshape(-1, 3)
    points = np.concatenate([corners + np.array((3 * n, 0, 0)) for n in range(20)])
    faces = np.arange(len(points)).reshape(-1, 3)  # no two share a point
    uv = points[:, :2] / 60
    paper: Any = TextureVisuals(uv=uv, image=Image.new("RGB", (64, 64), "red"))
    found: Any = smoothed(trimesh.Trimesh(points, faces, visual=paper, process=False))
    assert len(found.vertices) == 20 * 36
    assert np.abs(found.vertex_normals).max(axis=1) == pytest.approx(1.0), "all edges of a box are sharp"
    assert found.visual.material is paper.material
    assert found.visual.uv == pytest.approx(found.vertices[:, :2] / 60)


def test_what_is_see_through_has_a_material_that_blends() -> None:
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><geom size="1" rgba="1 0 0 1"/><geom size="1" rgba="0 0.5 1 0.4"/>
        <geom size="1" rgba="0 1 0 1"/></worldbody></mujoco>"""
    )
    red, clear, green = meshes_of(model, 0)
    assert material_of(clear).alphaMode == "BLEND"
    assert material_of(clear).baseColorFactor[3] == round(0.4 * 255)
    assert [material_of(mesh).alphaMode for mesh in (red, green)] == ["OPAQUE", "OPAQUE"]


def test_faces_that_meet_at_a_small_angle_share_a_normal_and_reversed_ones_do_not() -> None:
    points = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0.2], [-1, 0, 0.2]], float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 1, 2], [0, 3, 1]])  # a roof, and the same from below
    found = smoothed(trimesh.Trimesh(points, faces, process=False))
    ridge = found.vertex_normals[np.abs(found.vertices[:, 0]) < 1e-6]
    assert np.abs(ridge[:, 2]) == pytest.approx(1.0)
    assert set(ridge[:, 2].round()) == {-1.0, 1.0}
