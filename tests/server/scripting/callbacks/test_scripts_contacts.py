"""Scripts that are asked which shapes collide, and told of each physics step."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import pytest
from handler_calls import World
from scripted_world import said, scripted

pytestmark = pytest.mark.slow

pytest.importorskip("lupa")

BODY = """
<geom name="floor" type="plane" size="2 2 0.1"/>
<body name="ghost" pos="0 0 0.3"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
<body name="solid" pos="1 0 0.3"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
<body name="host" pos="0 1 5"><geom size="0.01" contype="0" conaffinity="0"/></body>
"""

GHOST = """
local ghost = sim.getObjectHandle('ghost')
asked = 0
function sysCall_contactCallback(inData)
    asked = asked + 1
    if inData.handle1 ~= ghost and inData.handle2 ~= ghost then return {ignoreContact = true} end
    return {ignoreContact = false, collisionResponse = false}
end
function sysCall_sensing() print(asked) asked = 0 end
"""


@pytest.fixture
def worlds() -> Iterator[list[World]]:
    """Every world in it is stopped at the end, and then MuJoCo asks nobody."""
    made: list[World] = []
    yield made
    for world in made:
        world.sim.stop()
    assert mujoco.get_mjcb_contactfilter() is None


def falling(worlds: list[World], **scripts: str) -> World:
    """Two boxes above a floor; scripts by the end of their annotation's name."""
    world = scripted({f"lua:{name}": text for name, text in scripts.items()}, body=BODY)
    world.sim.model.opt.gravity[2] = -9.81
    worlds.append(world)
    return world


def height(world: World, name: str) -> float:
    return world.call("simxGetObjectPosition", world.handle(name), -1)[2]


def test_a_script_lets_one_shape_fall_through_the_floor(worlds: list[World]) -> None:
    world = falling(worlds, host=GHOST)
    world.run(12)
    assert height(world, "ghost") < -0.5
    assert height(world, "solid") == pytest.approx(0.1, abs=0.01)
    counts = [int(line) for line in said(world)]
    assert max(counts) == 2  # two pairs, each once in a pass of 25 steps


EDITS = """
local function try(name, action)
    local ok, problem = pcall(action)
    if not told[name] then told[name] = true print(name, ok, problem) end
end
local self, solid = sim.getObjectHandle(sim.handle_self), sim.getObjectHandle('solid')
local eye = sim.getObjectHandle('eye')
told, times = {}, 0
function tryAll()
    times = times + 1
    if times > 60 then return end  -- a whole pass, before and after each step, and into the next
    try('create', function() sim.createDummy(0.1) end)
    try('remove', function() sim.removeObject(solid) end)
    try('parent', function() sim.setObjectParent(solid, self, true) end)
    try('load', function() sim.loadModel('pioneer p3dx.ttm') end)
    try('pose', function() sim.getObjectPosition(solid, -1) end)
end
"""


@pytest.mark.parametrize(
    ("call_back", "in_step"),
    [("sysCall_contactCallback", True), ("sysCall_dynCallback", False)],
)
def test_the_scene_is_not_edited_while_physics_is_under_way(
    worlds: list[World], call_back: str, in_step: bool, caplog: pytest.LogCaptureFixture
) -> None:
    body = BODY.replace(
        '<body name="host" pos="0 1 5">',
        '<body name="host" pos="0 1 5"><camera name="eye" resolution="8 4"/>',
    )
    pictures = """
    try('picture', function() sim.handleVisionSensor(eye) end)
    try('read', function() sim.readVisionSensor(eye) end)
    """
    tries = f"tryAll() {pictures if in_step else ''}"
    text = f"{EDITS} function {call_back}() {tries} return {{ignoreContact = true}} end"
    world = scripted({"lua:host": text}, body=body)
    world.sim.model.opt.gravity[2] = -9.81
    worlds.append(world)
    count = len(world.sim.scene.objects)
    world.run(12)
    lines = {line.split(", ")[0]: line for line in said(world)}
    for name in ("create", "remove", "parent", "load"):
        assert "false" in lines[name], lines
        assert f"within {call_back}, while physics is under way" in lines[name]
        assert "cannot be made, loaded, removed or put elsewhere" in lines[name]
    for name in ("picture", "read") if in_step else ():
        assert f" within {call_back}" in lines[name]
    assert "true" in lines["pose"]
    assert len(world.sim.scene.objects) == count
    assert height(world, "solid") == pytest.approx(0.1, abs=0.01)
    assert "Traceback" not in caplog.text


def test_nobody_is_asked_but_while_a_script_with_the_call_back_runs(worlds: list[World]) -> None:
    world = falling(worlds, host=GHOST)
    assert mujoco.get_mjcb_contactfilter() is None
    world.run(1)
    assert mujoco.get_mjcb_contactfilter() is not None
    world.sim.stop()
    assert mujoco.get_mjcb_contactfilter() is None


def test_a_customization_script_is_asked_in_every_run(worlds: list[World]) -> None:
    world = falling(worlds, **{"customization:host": GHOST})
    assert mujoco.get_mjcb_contactfilter() is None
    for _ in range(2):
        world.run(12)
        assert height(world, "ghost") < -0.5
        world.sim.stop()
        assert mujoco.get_mjcb_contactfilter() is None


def test_what_was_set_in_mujoco_before_is_asked_for_others_and_comes_back(worlds: list[World]) -> None:
    def nothing_touches(_model: object, _data: object, _first: int, _second: int) -> int:
        return 1

    mujoco.set_mjcb_contactfilter(nothing_touches)
    try:
        asking, plain = falling(worlds, host=GHOST), falling(worlds)
        for world in (asking, plain):
            world.run(12)
        assert height(asking, "solid") == pytest.approx(0.1, abs=0.01)
        assert height(plain, "solid") < -0.5
        asking.sim.stop()
        assert mujoco.get_mjcb_contactfilter() is nothing_touches
    finally:
        mujoco.set_mjcb_contactfilter(None)


def test_two_simulations_of_one_process_have_their_own_answers(worlds: list[World]) -> None:
    first = falling(worlds, host=GHOST)
    second = falling(worlds, host=GHOST.replace("'ghost'", "'solid'"))
    for world in (first, second):
        world.sim.start()
    for _ in range(12):
        first.parts.step()
        second.parts.step()
    assert height(first, "ghost") < -0.5 < 0.09 < height(first, "solid")
    assert height(second, "solid") < -0.5 < 0.09 < height(second, "ghost")
    first.sim.stop()
    assert mujoco.get_mjcb_contactfilter() is not None


def test_of_several_scripts_the_first_that_does_not_leave_the_pair_decides(worlds: list[World]) -> None:
    world = falling(
        worlds,
        host="function sysCall_contact(inData) return {ignoreContact = true, collisionResponse = false} end",
        solid="""function sysCall_contact(inData)
            if sim.getObjectName(inData.handle1) == 'floor' then print(inData.engine == sim.physics_mujoco) end
            return {collisionResponse = false}
        end""",
    )
    world.run(12)
    assert height(world, "solid") < -0.5
    assert set(said(world)) == {"true"}


def test_an_error_in_the_call_back_stops_the_script_and_the_contact_counts(worlds: list[World]) -> None:
    world = falling(worlds, host="function sysCall_contactCallback(inData) return nil + 1 end")
    world.run(12)
    assert "is stopped" in said(world)[-1]
    assert mujoco.get_mjcb_contactfilter() is None
    assert height(world, "ghost") == pytest.approx(0.1, abs=0.01)


def test_each_physics_step_is_told_before_and_after(worlds: list[World]) -> None:
    world = falling(
        worlds,
        host="""
        function sysCall_dynCallback(inData)
            local z = sim.getObjectPosition(sim.getObjectHandle('ghost'), -1)[3]
            print(inData.passCnt, inData.totalPasses, inData.afterStep, z < 0.3)
            step = inData.dynStepSize
        end
        function sysCall_sensing() print(step) end""",
    )
    world.sim.time_step = 0.004
    world.run(1)
    assert said(world) == [
        "1, 2, false, false",
        "1, 2, true, true",
        "2, 2, false, true",
        "2, 2, true, true",
        "0.002",
    ]
    world.sim.stop()
    world.run(1)
    assert len(said(world)) == 5
