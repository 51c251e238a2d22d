"""Forms of geoms: what is computed from their triangles is kept by content, through edits of the model."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from handler_calls import World

from simx_server.editing.copying import copy_objects
from simx_server.scene.geometry import forms
from simx_server.scene.geometry.forms import Forms, GeomTriangles
from simx_server.scene.geometry.triangles import is_convex
from simx_server.sensors.distance.box_tree import BoxTree

CUP = """<mesh name="{}" vertex="-1 -1 0  1 -1 0  1 1 0  -1 1 0  -1 -1 {top}  1 -1 1  1 1 1  -1 1 1"
  face="0 2 1  0 3 2  0 1 5  0 5 4  1 2 6  1 6 5  2 3 7  2 7 6  3 0 4  3 4 7" inertia="shell"/>"""
SCENE = f"""
<mujoco><asset>{CUP.format("cup", top=1)}{CUP.format("high", top=2)}
  <hfield name="field" nrow="2" ncol="3" size="1 1 1 1" elevation="0 1 0 1 0 1"/>
  <hfield name="turned" nrow="3" ncol="2" size="1 1 1 1" elevation="0 1 0 1 0 1"/></asset>
<worldbody>
  <body name="one"><geom type="mesh" mesh="cup"/></body>
  <body name="two" pos="9 0 0"><geom type="mesh" mesh="cup"/></body>
  <body name="three" pos="18 0 0"><geom type="mesh" mesh="high"/></body>
  <body name="four" pos="27 0 0"><geom type="box" size="1 1 1"/></body>
  <body name="five" pos="36 0 0"><geom type="sphere" size="1 1 1"/></body>
  <geom name="hills" type="hfield" hfield="field"/><geom name="vales" type="hfield" hfield="turned"/>
</worldbody></mujoco>
"""


@pytest.fixture
def world() -> World:
    return World(SCENE)


def triangles(world: World) -> GeomTriangles:
    return world.parts.instants.now().surroundings.triangles


def geom(world: World, name: str) -> int:
    (found,) = world.parts.instants.now().geoms_of([world.handle(name)])
    return int(found)


def test_geoms_share_a_form_only_if_all_of_it_is_equal(world: World) -> None:
    found = [triangles(world).form(number) for number in range(world.sim.model.ngeom)]
    assert found[geom(world, "one")] is found[geom(world, "two")]
    assert len({id(form) for form in found}) == len(found) - 1


def test_forms_and_their_trees_stay_through_an_edit(world: World) -> None:
    before = triangles(world).form(geom(world, "one"))
    tree = before.once(BoxTree)
    (copy,) = copy_objects(world.parts, [world.handle("four")])
    world.sim.refresh()
    after = triangles(world).form(geom(world, "one"))
    assert copy in world.sim.scene.objects
    assert after is before
    assert after.once(BoxTree) is tree


def test_forms_of_earlier_scenes_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(forms, "_SPARE", 30)
    known = Forms()
    models = [
        mujoco.MjModel.from_xml_string(
            f'<mujoco><worldbody><geom type="box" size="1 1 {height}"/></worldbody></mujoco>'
        )
        for height in range(1, 9)
    ]
    first = known.of(models[0], 0)
    for model in models:
        assert known.of(models[0], 0) is first, "it is used again and again"
        known.of(model, 0)
    for model in models[1:]:
        known.of(model, 0)
    assert known.of(models[0], 0) is not first


def test_a_body_with_one_dent_or_hole_is_not_convex() -> None:
    points = np.random.default_rng(0).normal(size=(400, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    spec = mujoco.MjSpec()
    spec.add_mesh(name="hull", uservert=points.ravel())
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hull")
    ball = GeomTriangles(spec.compile()).of(0)[0]
    assert len(ball) == 796
    assert is_convex(ball)
    for corner in (ball[0, 0], ball[395, 1]):
        dented = ball.copy()
        dented[np.all(ball == corner, axis=2)] *= 0.9
        assert not is_convex(dented)
    assert not is_convex(ball[1:]), "it is open"
