"""Drawing objects of scripts: kept as set until the stop."""

from __future__ import annotations

import random

import pytest
from scripted_world import said, scripted
from sim_api_calls import ScriptWorld, world

from simx_server.parts.drawing import Layout
from simx_server.scene.poses.poses import IDENTITY

__all__ = ["world"]


def items(world: ScriptWorld, handle: int) -> list[tuple[float, ...]]:
    """Of one drawing object, in the world."""
    (found,) = [each for drawn, each in world.parts.drawings.shown() if drawn.handle == handle]
    return found


def test_points_and_lines_are_kept_with_their_settings(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "d = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 100, {1, 0, 0}, nil, nil, {0, 0, 1}) return d"
    )
    drawn = world.parts.drawings.get(handle)
    assert (drawn.kind, drawn.size, drawn.parent, drawn.most) == (1, 2, -1, 100)
    assert (drawn.color, drawn.specular, drawn.emission) == ((1, 0, 0), (0, 0, 0), (0, 0, 1))
    before = world.parts.drawings.version
    assert world.lua("return sim.addDrawingObjectItem(d, {1, 2, 3, 4, 5, 6})") == [1]
    assert items(world, handle) == [(1, 2, 3, 4, 5, 6)]
    assert world.parts.drawings.version != before
    world.fails("sim.addDrawingObjectItem(d, {1, 2, 3})", "is 6 numbers; got 3")


def test_items_move_with_the_parent(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "h = sim.getObjectHandle('cube') d = sim.addDrawingObject(sim.drawing_discpoints, 1, 0, h, 9) "
        "sim.addDrawingObjectItem(d, {2, 0, 2, 1, 0, 0}) "
        "sim.setObjectPosition(h, -1, {5, 5, 5}) sim.setObjectOrientation(h, -1, {0, 0, math.pi / 2}) return d"
    )
    assert items(world, handle) == [pytest.approx((5, 5, 6, 0, 1, 0), abs=1e-9)]


def test_new_kinds_have_a_quaternion_and_may_be_local(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "local h = sim.getObjectHandle('cube') "
        "d = sim.addDrawingObject(sim.drawing_cubepts + sim.drawing_local, 1, 0, h, 9) "
        "sim.addDrawingObjectItem(d, {0, 0, 1, 0, 0, 0, 1}) return d"
    )
    assert items(world, handle) == [pytest.approx((2, 0, 2, 0, 0, 0, 1))]


def test_colours_and_sizes_of_items_follow_their_points(world: ScriptWorld) -> None:
    (handle,) = world.lua(
        "d = sim.addDrawingObject(sim.drawing_spherepoints + sim.drawing_itemcolors + sim.drawing_itemsizes, 1, 0) "
        "sim.addDrawingObjectItem(d, {1, 2, 3, 0.1, 0.2, 0.3, 7}) return d"
    )
    assert items(world, handle) == [(1, 2, 3, 0.1, 0.2, 0.3, 7)]


def test_a_full_object_refuses_or_overwrites_the_oldest(world: ScriptWorld) -> None:
    add = "d = sim.addDrawingObject(sim.drawing_points{}, 1, 0, -1, 2) local last "
    add += "for i = 1, 3 do last = sim.addDrawingObjectItem(d, {{i, 0, 0}}) end return d, last"
    full, last = world.lua(add.format(""))
    assert (items(world, full), last) == ([(1, 0, 0), (2, 0, 0)], 0)
    cyclic, last = world.lua(add.format(" + sim.drawing_cyclic"))
    assert (items(world, cyclic), last) == ([(3, 0, 0), (2, 0, 0)], 1)


def test_near_duplicates_are_left_out(world: ScriptWorld) -> None:
    handle, *results = world.lua(
        "d = sim.addDrawingObject(sim.drawing_points, 1, 0.1, -1, 9) "
        "return d, sim.addDrawingObjectItem(d, {0, 0, 0}), sim.addDrawingObjectItem(d, {0, 0, 0.05}), "
        "sim.addDrawingObjectItem(d, {0, 0, 0.2})"
    )
    assert results == [1, 0, 1]
    assert items(world, handle) == [(0, 0, 0), (0, 0, 0.2)]


def test_many_items_are_added_or_set_at_once_and_nil_clears(world: ScriptWorld) -> None:
    (handle,) = world.lua("d = sim.addDrawingObject(sim.drawing_points, 1, 0) return d")
    world.lua("sim.addDrawingObjectItem(d + sim.handleflag_addmultiple, {1, 1, 1, 2, 2, 2})")
    assert items(world, handle) == [(1, 1, 1), (2, 2, 2)]
    world.lua("sim.addDrawingObjectItem(d + sim.handleflag_setmultiple, {3, 3, 3, 4, 4, 4})")
    assert items(world, handle) == [(3, 3, 3), (4, 4, 4)]
    assert world.lua("return sim.addDrawingObjectItem(d, nil)") == [1]
    assert items(world, handle) == []


def test_objects_go_when_they_are_removed_with_their_parent_and_at_the_stop(world: ScriptWorld) -> None:
    one, other = world.lua(
        "a = sim.addDrawingObject(sim.drawing_points, 1, 0) "
        "b = sim.addDrawingObject(sim.drawing_points, 1, 0, sim.getObjectHandle('cube')) return a, b"
    )
    world.call("simxRemoveObject", world.handle("cube"))
    assert [drawn.handle for drawn, _ in world.parts.drawings.shown()] == [one]
    world.fails("sim.addDrawingObjectItem(b, {1, 1, 1})", f"no drawing object with handle {other}")
    assert world.lua("return sim.removeDrawingObject(a)") == [1]
    assert world.lua("return sim.removeDrawingObject(a + sim.handleflag_silenterror)") == [1]
    world.fails("sim.removeDrawingObject(-1)", "no drawing object with handle -1")
    world.lua("sim.addDrawingObject(0, 1, 0) sim.addDrawingObject(0, 1, 0)")
    assert world.lua("return sim.removeDrawingObject(sim.handle_all)") == [1]
    assert world.parts.drawings.shown() == []
    world.lua("sim.addDrawingObject(0, 1, 0)")
    world.call("simxStopSimulation")
    assert world.parts.drawings.shown() == []


def test_drawings_of_customization_scripts_and_persistent_ones_outlive_the_run() -> None:
    body = "function sysCall_init() sim.addDrawingObject({}, 1, 0) sim.addDrawingObject(0, 1, 0) end "
    removing = "function sysCall_afterSimulation() print(sim.removeDrawingObject(1)) end"
    world = scripted(
        {
            "lua:customization:base": body.format("0") + removing,
            "lua:base": body.format("sim.drawing_persistent"),
        }
    )
    world.run(1)
    assert len(world.parts.drawings.shown()) == 4
    world.call("simxStopSimulation")
    assert said(world) == ["1"]
    assert [drawn.handle for drawn, _ in world.parts.drawings.shown()] == [2, 3]


def test_what_cannot_be_drawn_is_told(world: ScriptWorld) -> None:
    world.fails("sim.addDrawingObject(20, 1, 0)", "20 is no kind of drawing object")
    world.fails("sim.addDrawingObject(0, 1, 0, 999)", "no object with handle 999")
    world.fails("sim.addDrawingObject(0, 1, 0, -1, -5)", "holds 1 to 100000 items")
    world.fails("sim.addDrawingObject(0, 1, 0, -1, 5, {1})", "a colour is")


@pytest.mark.parametrize("flags", [0, 1, 2, 3, 6, 7, 8, 9, 0x20, 0x42, 0x80, 0x20003, 0x80001])
def test_items_in_the_world_are_those_of_a_parent_at_its_origin(flags: int) -> None:
    layout, chance = Layout.of(flags), random.Random(flags)
    for _ in range(50):
        item = [
            chance.choice((0.0, -0.0, 1.5, -1e300, 5e-324, chance.uniform(-1, 1))) for _ in range(layout.size)
        ]
        if layout.has_quaternion:
            item[3:7] = 0.0, 0.6, 0.0, 0.8
        assert repr(layout.unmoved(item)) == repr(layout.moved(IDENTITY, item))  # -0.0 is not 0.0
