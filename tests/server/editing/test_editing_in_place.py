"""Edits that need no compile give the scene that a compile gives: objects, poses, state, and what the stop restores."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from handler_calls import World
from seeds import seeds

from simx_server.errors import CommandError
from simx_server.history.models import pack_model, unpack_model
from simx_server.scene.editing import recompile
from simx_server.scene.editing.in_place import sites
from simx_server.scene.editing.model_state import get_state
from simx_server.scene.object_listing import list_objects
from simx_server.scene.poses import frames
from simx_server.scene.tree import Builder

SCENE = """
<mujoco>
  <option timestep="0.01"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="table" pos="1 0 0.2">
      <geom name="top" type="box" size="0.3 0.3 0.02"/><geom type="cylinder" size="0.02 0.1" pos="0 0 -0.1"/>
      <site name="mark" pos="0 0 0.1"/>
    </body>
    <body name="arm" pos="-1 0 0.5">
      <geom size="0.1"/>
      <body name="link" pos="0 0 0.2"><joint name="hinge" axis="0 1 0"/><geom size="0.05" pos="0.2 0 0"/>
        <site name="tip" pos="0.3 0 0"/><site name="scale" pos="0.2 0 0"/></body>
    </body>
    <body name="ball" pos="0 0.5 1"><freejoint/><geom size="0.1"/></body>
    <body name="post" pos="0 -1 0.3"><geom type="box" size="0.05 0.05 0.3"/></body>
    <site name="nail" pos="0 -1 0.7"/>
  </worldbody>
  <tendon><spatial name="rope"><site site="nail"/><site site="tip"/></spatial></tendon>
  <sensor><force site="scale"/><torque site="scale"/><rangefinder site="mark"/></sensor>
</mujoco>
"""


@pytest.fixture
def compiles(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows by one with each compile of an edit."""
    made: list[int] = []
    real = recompile.compile_spec

    def counted(*arguments: Any) -> Any:
        made.append(1)
        return real(*arguments)

    monkeypatch.setattr(recompile, "compile_spec", counted)
    return made


def settle(world: World) -> None:
    """Compile the scene as it is."""
    recompile.edit(world.sim, lambda spec: None, set())


def shown(world: World) -> list[Any]:
    """Names, tree, kinds and poses of all objects."""
    sim = world.sim
    poses = {
        handle: np.round(np.concatenate(frames.get_pose(sim, handle)), 12) for handle in sim.scene.objects
    }
    return [(each, poses[each["handle"]].tolist()) for each in list_objects(sim)]


def check(world: World) -> None:
    """The look-up tables fit the model, and a compile changes nothing."""
    scene, model = world.sim.scene, world.sim.model
    builder = Builder(model, scene.annotations, scene.hidden_bodies, None, scene.unseen_sites)
    builder.build()
    assert {(item.element, item.element_name, item.id, item.body) for item in builder.objects.values()} == {
        (item.element, item.element_name, item.id, item.body) for item in scene.objects.values()
    }
    before, state = shown(world), get_state(model, world.sim.data)
    settle(world)
    assert shown(world) == before
    assert np.array_equal(get_state(world.sim.model, world.sim.data), state)


def test_fifty_dummies_cost_four_compiles(compiles: list[int]) -> None:
    world = World(SCENE)
    table = world.handle("table")
    handles = [world.call("simxCreateDummy", 0.01, None) for _ in range(50)]
    for number, handle in enumerate(handles):
        world.call("simxSetObjectParent", handle, table, True)
        world.call("simxSetObjectPosition", handle, -1, [0.1 * number, 0, 1])
    assert len(compiles) == 4
    check(world)
    assert [world.sim.scene.get(handle).name for handle in handles[:3]] == ["Dummy", "Dummy0", "Dummy1"]
    assert all(world.sim.scene.get(handle).parent == table for handle in handles)
    del compiles[:]
    for handle in handles:
        world.call("simxRemoveObject", handle)
    assert not compiles
    check(world)
    assert not set(handles) & set(world.sim.scene.objects)


def test_a_dummy_moves_with_its_new_parent_and_stays_with_the_old_one_s_place(compiles: list[int]) -> None:
    world = World(SCENE)
    dummy, ball = world.call("simxCreateDummy", 0.02, None), world.handle("ball")
    world.run()
    del compiles[:]
    world.call("simxSetObjectParent", dummy, ball, False)
    assert frames.get_position(world.sim, dummy, ball) == pytest.approx([0, 0, 0])
    for _ in range(5):
        world.parts.step()
    assert frames.get_position(world.sim, dummy) == frames.get_position(world.sim, ball)
    before = frames.get_pose(world.sim, dummy)
    world.call("simxSetObjectParent", dummy, -1, True)
    assert frames.get_position(world.sim, dummy) == pytest.approx(before[0])
    assert not compiles
    check(world)


def test_sites_that_mujoco_uses_are_moved_by_a_compile(compiles: list[int]) -> None:
    world = World(SCENE)
    table = world.handle("table")
    light = {
        name: sites.is_light(world.sim, world.sim.scene.get(world.handle(name))) for name in ("mark", "tip")
    }
    assert light == {"mark": True, "tip": False}
    for name in ("nail", "tip"):
        world.call("simxSetObjectParent", world.handle(name), table, True)
        assert compiles.pop()
    world.call("simxSetObjectParent", world.handle("mark"), -1, True)
    assert not compiles
    check(world)


def test_children_of_a_removed_dummy_stay_in_place_under_its_parent() -> None:
    world = World(SCENE)
    post, ball = world.handle("post"), world.handle("ball")
    outer, inner = (world.call("simxCreateDummy", 0.02, None) for _ in range(2))
    for child, parent in ((outer, post), (inner, outer), (ball, outer)):
        world.call("simxSetObjectParent", child, parent, True)
    before = frames.get_position(world.sim, ball)
    world.call("simxRemoveObject", outer)
    assert {world.sim.scene.get(each).parent for each in (inner, ball)} == {post}
    assert frames.get_position(world.sim, ball) == before
    check(world)


def test_the_stop_brings_back_removed_dummies_and_takes_new_ones() -> None:
    world = World(SCENE)
    old = world.call("simxCreateDummy", 0.02, None)
    world.call("simxSetObjectParent", old, world.handle("table"), True)
    before, arrays = shown(world), bytes(world.sim.model.site_pos)
    for _ in range(2):
        world.run()
        new = world.call("simxCreateDummy", 0.03, None)
        world.call("simxSetObjectParent", old, new, True)
        world.call("simxRemoveObject", old)
        world.call("simxSetObjectPosition", new, -1, [1, 2, 3])
        world.parts.step()
        world.call("simxStopSimulation")
        assert shown(world) == before
        assert bytes(world.sim.model.site_pos) == arrays
    assert world.call("simxCreateDummy", 0.03, None) > new
    check(world)


def test_a_placed_dummy_has_the_next_edit_compute_no_constants(monkeypatch: pytest.MonkeyPatch) -> None:
    world = World(SCENE)
    world.call("simxCreateDummy", 0.05, None)
    computed: list[int] = []
    monkeypatch.setattr(recompile, "set_constants", lambda model: computed.append(1))
    settle(world)
    assert not computed


def test_a_new_dummy_has_no_velocity(compiles: list[int]) -> None:
    world = World(SCENE)
    world.call("simxCreateDummy", 0.02, None)
    world.run(2)
    del compiles[:]
    dummy = world.call("simxCreateDummy", 0.02, None)
    world.parts.step()
    assert not compiles
    assert world.call("simxGetObjectVelocity", dummy) == ([0.0] * 3, [0.0] * 3)


def test_a_kept_moment_has_dummies_that_were_made_without_a_compile() -> None:
    world = World(SCENE)
    handles = [world.call("simxCreateDummy", 0.02, None) for _ in range(3)]
    world.call("simxRemoveObject", handles[0])
    scene, _ = unpack_model(pack_model(world.sim.scene, world.sim.model))
    assert scene.objects.keys() == world.sim.scene.objects.keys()
    assert scene.slots == world.sim.scene.slots
    assert {site.name for site in scene.spec.sites} == {site.name for site in world.sim.scene.spec.sites}


def test_a_full_scene_refuses_a_dummy() -> None:
    world = World(SCENE)
    world.call("simxCreateDummy", 0.02, None)
    object.__setattr__(world.sim.limits, "objects", len(world.sim.scene.objects))
    with pytest.raises(CommandError, match="objects"):
        world.call("simxCreateDummy", 0.02, None)


# --- random edits, with a compile after each and without ------------------------------------------


def random_call(world: World, choose: random.Random, model: Path) -> tuple[str, list[Any]]:
    handles = list(world.sim.scene.objects)
    one, other = choose.choice(handles), choose.choice([*handles, -1])
    place = [choose.uniform(-1, 1) for _ in range(3)]
    calls: list[tuple[int, str, list[Any]]] = [
        (6, "simxCreateDummy", [0.01, None]),
        (6, "simxSetObjectParent", [one, other, choose.random() < 0.5]),
        (4, "simxRemoveObject", [one]),
        (4, "simxSetObjectPosition", [one, -1, place]),
        (1, "simxCopyPasteObjects", [[one]]),
        (1, "simxLoadModel", [str(model), 0]),
    ]
    weights = [weight for weight, _, _ in calls]
    _, name, arguments = choose.choices(calls, weights)[0]
    return name, arguments


def differential(seed: int, model: Path, after: Callable[[World], object]) -> World:
    """Make random edits, started and stopped; `after` each."""
    choose, world = random.Random(seed), World(SCENE, workspace=model.parent)
    for number in range(60):
        if number % 20 == 5:
            world.run(1)
        elif number % 20 == 19:
            world.call("simxStopSimulation")
        try:
            world.call(*(lambda call: (call[0], *call[1]))(random_call(world, choose, model)))
        except CommandError:
            continue
        after(world)
        if number % 3 == 0 and world.sim.is_running:
            world.parts.step()
    return world


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(2))
def test_edits_with_a_compile_after_each_give_the_same(seed: int, tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(
        "<mujoco><worldbody><body name='lamp'><geom size='0.02' contype='0' conaffinity='0'/>"
        "<site name='bulb' pos='0 0 0.1'/></body></worldbody></mujoco>",
        encoding="utf-8",
    )
    model = tmp_path / "model.xml"
    without = differential(seed, model, lambda world: None)
    compiled = differential(seed, model, check)
    assert shown(without) == shown(compiled)
    assert np.array_equal(without.sim.data.qpos, compiled.sim.data.qpos)
    assert np.array_equal(without.sim.data.qvel, compiled.sim.data.qvel)
    check(without)
