"""What `simx:object` and its neighbours say about objects, which MJCF cannot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest
from worlds.real_world import RealWorld

from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_text
from simx_server.scene.objects import ObjectKind, Scene
from simx_server.world.world import World

SCENE = """<mujoco><custom>
<text name="simx:object:track" data="type=path parent=cart order=1 layers=0x0400"/>
<text name="simx:object:cart" data="order=0 alias=vehicle"/>
<text name="simx:object:load" data="parent=track order=2"/>
{more}
</custom><worldbody>
<body name="load" pos="0 0 2"><freejoint/><geom size="0.1"/></body>
<site name="track"/>
<body name="cart" pos="0 0 1"><freejoint/><geom size="0.1" mass="2"/>
<body name="cover"><geom size="0.1" mass="3"/></body></body>
<body name="ball"><joint name="knob" type="ball"/><geom size="0.1"/></body>
</worldbody></mujoco>"""


def scene_of(more: str = "") -> tuple[Scene, mujoco.MjModel]:
    return load_text(SCENE.format(more=more))


def test_handles_follow_the_order_and_others_come_after() -> None:
    scene, _ = scene_of()
    assert [item.name for item in scene.objects.values()][:3] == ["cart", "track", "load"]
    assert list(scene.objects) == sorted(scene.objects)
    assert all(scene.objects[handle].handle == handle for handle in scene.objects)


def test_parents_types_and_aliases_are_those_of_the_annotations() -> None:
    scene, _ = scene_of()
    track, load = scene.by_name("track"), scene.by_name("load")
    assert track is not None
    assert load is not None
    assert scene.objects[track].kind == ObjectKind.PATH
    assert scene.objects[load].parent == track
    assert scene.resolve("/vehicle/track/load") == load


def test_a_parent_below_the_object_itself_is_an_error() -> None:
    with pytest.raises(SceneError, match="ancestor of itself"):
        load_text(SCENE.replace("order=0 alias=vehicle", "parent=load").format(more=""))


def test_an_unknown_parent_is_an_error_that_names_it() -> None:
    with pytest.raises(SceneError, match="parent=nobody"):
        scene_of('<text name="simx:object:cover" data="parent=nobody"/>')


def test_a_static_shape_on_a_moving_body_has_no_weight() -> None:
    _, heavy = scene_of()
    scene, light = scene_of('<text name="simx:shape:cover" data="static=yes"/>')
    assert heavy.body_subtreemass[heavy.body("cart").id] == pytest.approx(5)
    assert light.body_subtreemass[light.body("cart").id] == pytest.approx(2)
    assert scene.weightless_bodies == {"cover"}


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    (tmp_path / "scene.xml").write_text(
        SCENE.format(
            more='<text name="simx:shape:cart" data="mask=0x0f0f first_velocity=1,0,0,0,0,2"/>'
            '<text name="simx:joint:knob" data="turn=0,0,0,2 mode=passive"/>'
            '<text name="simx:model:cart" data="base=yes properties=0x10"/>'
        )
    )
    made = RealWorld(tmp_path / "scene.xml")
    yield made.parts
    made.close()


def test_layers_masks_and_model_properties_can_be_read_back(world: World) -> None:
    scene = world.simulation.scene
    assert world.object_settings.layers(scene.resolve("track")) == 0x0400
    assert world.object_settings.mask(scene.resolve("cart")) == 0x0F0F
    assert scene.model_property(scene.resolve("cart")) == 0x10


def test_the_first_velocity_counts_in_every_run(world: World) -> None:
    simulation = world.simulation
    dof = int(simulation.model.body_dofadr[simulation.model.body("cart").id])
    for _ in range(2):
        simulation.start()
        assert simulation.data.qvel[dof] == pytest.approx(1)
        assert simulation.data.qvel[dof + 5] == pytest.approx(2)
        simulation.stop()


def test_a_spherical_joint_starts_with_its_turn(world: World) -> None:
    simulation = world.simulation
    address = int(simulation.model.jnt_qposadr[simulation.model.joint("knob").id])
    assert simulation.data.qpos[address : address + 4].tolist() == [0, 0, 0, 1]
