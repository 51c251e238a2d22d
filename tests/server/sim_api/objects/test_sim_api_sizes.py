"""Sizes and scaling of objects by scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sim_api_calls import ScriptWorld

SCENE = """
<mujoco>
  <compiler angle="radian"/><option timestep="0.005" gravity="0 0 0"/>
  <asset>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1"/>
    <hfield name="hills" nrow="2" ncol="3" size="1 2 0.5 0.1" elevation="0 1 0 0 0 1"/>
  </asset>
  <worldbody>
    <body name="box"><freejoint/><geom type="box" size="0.1 0.2 0.3" pos="0.1 0 0" mass="2"/></body>
    <body name="turned" pos="3 0 0"><geom type="box" size="0.1 0.2 0.3" euler="0 0 1.5707963267948966"/></body>
    <body name="leaning" pos="6 0 0"><geom type="box" size="0.1 0.2 0.3" euler="0 0 0.5"/></body>
    <body name="ball" pos="9 0 0"><geom size="0.1"/></body>
    <body name="tin" pos="12 0 0"><geom type="cylinder" size="0.1 0.2"/></body>
    <body name="pill" pos="15 0 0"><geom type="capsule" size="0.1 0.2"/></body>
    <body name="mesh" pos="18 0 0"><geom type="mesh" mesh="wedge" pos="0.5 0 0"/></body>
    <body name="field" pos="21 0 0"><geom type="hfield" hfield="hills"/></body>
    <geom name="wall" type="box" size="0.1 0.1 0.1" pos="0 5 0"/>
    <geom name="floor" type="plane" size="0 0 1" pos="0 0 -9"/>
    <body name="base" pos="0 9 0">
      <geom type="box" size="0.5 0.5 0.5" mass="1"/>
      <site name="mark" pos="0 0 1" size="0.05"/>
      <site name="eye" pos="1 0 0"/>
      <camera name="view" pos="0 1 0" projection="orthographic" fovy="2"/>
      <body name="slide_part" pos="0 0 2">
        <joint name="slide" type="slide" axis="0 0 1" range="-1 1"/><geom size="0.1" mass="1"/>
        <body name="hinge_part" pos="0 0 1">
          <joint name="hinge" axis="0 0 1" range="-1 1"/><geom size="0.1" mass="1"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator><velocity name="a" joint="slide" kv="10"/><velocity name="b" joint="hinge" kv="10"/></actuator>
  <custom>
    <text name="simx:proximity:eye" data="type=cone range=1 angle_deg=20 offset=0.1"/>
    <text name="simx:vision:view" data="near=0.1 far=5"/>
    <text name="simx:joint:slide" data="control=position max_force=10"/>
    <text name="simx:joint:hinge" data="control=spring K=8 C=1 max_force=10"/>
    <text name="simx:model:base" data="base=yes"/>
    <text name="simx:object:ball" data="size_factor=2 size_values=2,2,2"/>
  </custom>
</mujoco>
"""


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    return ScriptWorld(tmp_path, SCENE, owner="box")


def scale(world: ScriptWorld, name: str, x: float, y: float, z: float) -> None:
    assert world.value(f"sim.scaleObject(sim.getObject('/{name}'), {x}, {y}, {z}, 0)") == 1


def box(world: ScriptWorld, name: str) -> Any:
    return pytest.approx(world.lua(f"return (sim.getShapeBB(sim.getObject('/{name}')))")[0], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("box", [0.4, 1.2, 2.4]),
        ("turned", [0.8, 0.6, 2.4]),
        ("ball", [0.4, 0.6, 0.8]),
        ("tin", [0.4, 0.4, 1.6]),
        ("pill", [0.4, 0.4, 2.4]),
        ("mesh", [2.0, 3.0, 4.0]),
        ("wall", [0.4, 0.6, 0.8]),
    ],
)
def test_a_shape_is_scaled_along_its_axes(world: ScriptWorld, name: str, size: list[float]) -> None:
    scale(world, name, 2, 3, 4)
    assert size == box(world, name)
    position = world.value(f"sim.getObjectPosition(sim.getObject('/{name}'), -1)")
    scale(world, name, 0.5, 1 / 3 if name not in ("tin", "pill") else 0.5, 0.25)
    assert world.value(f"sim.getObjectPosition(sim.getObject('/{name}'), -1)") == pytest.approx(position)


def test_a_box_that_leans_becomes_the_mesh_that_it_would_be(world: ScriptWorld) -> None:
    before = world.lua("local m = sim.getShapeMesh(sim.getObject('/leaning')) return m")[0]
    scale(world, "leaning", 2, 1, 1)
    after = world.lua("local m = sim.getShapeMesh(sim.getObject('/leaning')) return m")[0]
    wanted = np.array(before).reshape(-1, 3) * (2, 1, 1)
    found = np.array(after).reshape(-1, 3)
    assert all(np.abs(found - corner).max(axis=1).min() < 1e-6 for corner in wanted)
    assert len(found) == len(wanted)


def test_a_height_field_is_scaled(world: ScriptWorld) -> None:
    scale(world, "field", 2, 1, 3)
    geom = int(world.sim.model.body("field").geomadr[0])
    assert world.sim.model.hfield_size[world.sim.model.geom_dataid[geom]].tolist() == pytest.approx(
        [2, 2, 1.5, 0.3]
    )


def test_places_of_parts_are_scaled_with_the_shape(world: ScriptWorld) -> None:
    scale(world, "box", 2, 1, 1)
    _, pose = world.lua("return sim.getShapeBB(sim.getObject('/box'))")
    assert pose[:3] == pytest.approx([0.2, 0, 0], abs=1e-9)


def test_mass_and_inertia_are_those_of_the_same_density(world: ScriptWorld) -> None:
    scale(world, "box", 2, 3, 4)
    mass, inertia, centre = world.lua(
        "local h = sim.getObject('/box') return sim.getShapeMassAndInertia(h, sim.getObjectMatrix(h, -1))"
    )
    x, y, z = 0.4, 1.2, 2.4
    assert mass == pytest.approx(2 * 24)
    assert [inertia[0], inertia[4], inertia[8]] == pytest.approx(
        [mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y)]
    )
    assert centre == pytest.approx([0.2, 0, 0])


def test_the_box_of_a_shape_can_be_set(world: ScriptWorld) -> None:
    world.lua("sim.setShapeBB(sim.getObject('/ball'), {1, 2, 3})")
    assert box(world, "ball") == [1, 2, 3]
    assert world.value("sim.getObjectSizeValues(sim.getObject('/ball'))") == pytest.approx([10, 20, 30])
    world.fails("sim.setShapeBB(sim.getObject('/ball'), {1, 2})", "three numbers not below 0")


def test_size_factors_add_up_and_begin_with_those_of_the_file(world: ScriptWorld) -> None:
    read = "local h = sim.getObject('/%s') return sim.getObjectSizeFactor(h), sim.getObjectSizeValues(h)"
    assert world.lua(read % "ball") == [2, [2, 2, 2]]
    assert world.lua(read % "tin") == [1, [1, 1, 1]]
    scale(world, "ball", 2, 2, 1)
    factor, values = world.lua(read % "ball")
    assert factor == pytest.approx(2 * 4 ** (1 / 3))
    assert values == [4, 4, 2]


def test_other_objects_are_scaled_alike_along_all_axes(world: ScriptWorld) -> None:
    scale(world, "mark", 2, 2, 2)
    size = world.value("sim.getObjectFloatParam(sim.getObject('/mark'), sim.dummyfloatparam_size)")
    assert size == pytest.approx(0.2)
    scale(world, "view", 2, 2, 2)
    settings = world.parts.vision.settings(world.handle("view"))
    assert (settings.near, settings.far, settings.orthographic_size) == (0.2, 10, 4)
    scale(world, "eye", 3, 3, 3)
    optics = world.parts.proximity._look(world.sim.scene.get(world.handle("eye")))
    assert (optics.reach, optics.offset) == pytest.approx((3, 0.3))
    world.fails("sim.scaleObject(sim.getObject('/mark'), 2, 1, 1)", "can only be scaled alike")


def test_a_prismatic_joint_and_its_force_follow_the_size(world: ScriptWorld) -> None:
    world.lua("sim.setJointPosition(sim.getObject('/slide'), 0.5)")
    scale(world, "slide", 2, 2, 2)
    assert world.lua("return sim.getJointInterval(sim.getObject('/slide'))") == [False, [-2, 4]]
    assert world.value("sim.getJointPosition(sim.getObject('/slide'))") == pytest.approx(1.0)
    assert world.value("sim.getJointMaxForce(sim.getObject('/slide'))") == pytest.approx(80)
    scale(world, "hinge", 2, 2, 2)
    state = world.sim.joints.state(world.handle("hinge"))
    assert (state.max_force, state.k, state.c) == pytest.approx((160, 128, 16))
    assert world.lua("return sim.getJointInterval(sim.getObject('/hinge'))") == [False, [-1, 2]]


def test_a_model_is_scaled_with_all_below_it(world: ScriptWorld) -> None:
    names = ("base", "mark", "eye", "slide", "slide_part", "hinge", "hinge_part")
    places = {
        name: np.array(world.value(f"sim.getObjectPosition(sim.getObject('/{name}'), -1)")) for name in names
    }
    assert world.value("sim.scaleObjects({sim.getObject('/base')}, 2, false)") == 1
    for name in names:
        wanted = places["base"] + 2 * (places[name] - places["base"])
        found = world.value(f"sim.getObjectPosition(sim.getObject('/{name}'), -1)")
        assert found == pytest.approx(wanted.tolist(), abs=1e-6), name
    assert box(world, "base") == [2, 2, 2]
    assert world.value("sim.getShapeMass(sim.getObject('/base'))") == pytest.approx(8)


def test_places_of_the_objects_themselves_are_scaled_on_request(world: ScriptWorld) -> None:
    world.lua("sim.scaleObjects({sim.getObject('/ball')}, 2, true)")
    assert world.value("sim.getObjectPosition(sim.getObject('/ball'), -1)") == pytest.approx([18, 0, 0])


def test_the_stop_undoes_what_a_run_has_scaled(world: ScriptWorld) -> None:
    scale(world, "ball", 2, 2, 2)
    scale(world, "eye", 2, 2, 2)
    world.sim.stop()
    world.run(0)
    assert box(world, "ball") == [0.2, 0.2, 0.2]
    assert world.value("sim.getObjectSizeFactor(sim.getObject('/ball'))") == 2
    assert world.parts.proximity._look(world.sim.scene.get(world.handle("eye"))).reach == 1


def test_meshes_do_not_pile_up_when_a_script_scales_again_and_again(world: ScriptWorld) -> None:
    for _ in range(4):
        scale(world, "mesh", 1.1, 1, 1)
    assert world.sim.model.nmesh == 2


def test_impossible_factors_are_refused(world: ScriptWorld) -> None:
    world.fails("sim.scaleObject(sim.getObject('/ball'), 0, 1, 1)", "a number above 0")
    world.fails("sim.scaleObject(sim.getObject('/ball'), 1e9, 1, 1)", "a size is at most")
    world.fails("sim.scaleObject(sim.getObject('/floor'), 2, 2, 2)", "infinite plane")
    assert box(world, "ball") == [0.2, 0.2, 0.2]


def test_boxes_around_objects(world: ScriptWorld) -> None:
    assert box(world, "box") == [0.2, 0.4, 0.6]
    parts = [0.5 + 1.005, 0.5 + 1.005, 0.5 + 3.1]  # to the far sides of the sensors and the upper part
    assert world.value("sim.getModelBB(sim.getObject('/base'))") == pytest.approx(parts)
    world.fails(
        "sim.getShapeBB(sim.getObject('/hinge'))", "'hinge' is a joint, but this command needs a shape"
    )


FLAT = '<mujoco><worldbody><body name="robot"><geom size="0.1"/></body></worldbody></mujoco>'


def test_a_flat_mesh_has_no_height(tmp_path: Path) -> None:
    """Programs take a shape without any height for a plane."""
    points = "{-0.2, -0.1, 0, 0.2, -0.1, 0, 0.2, 0.1, 0, -0.2, 0.1, 0}"
    world = ScriptWorld(tmp_path, FLAT)
    assert world.lua(
        f"local h = sim.createMeshShape(0, 0, {points}, {{0, 1, 2, 0, 2, 3}}) "
        "local _, low = sim.getObjectFloatParameter(h, 17) "
        "local _, high = sim.getObjectFloatParameter(h, 20) return low, high"
    ) == [0.0, 0.0]
