"""Mechanisms that a script builds joint by joint in an environment of simIK."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld

TWO_LINKS = """
local env = simIK.createEnvironment()
local base, tip, target = simIK.createDummy(env, 'base'), simIK.createDummy(env), simIK.createDummy(env, 'goal')
local first = simIK.createJoint(env, simIK.jointtype_revolute, 'first')
local second = simIK.createJoint(env, simIK.jointtype_revolute)
simIK.setObjectPose(env, base, {1, 0, 0, 0, 0, 0, 1})
simIK.setObjectPose(env, first, {1, 0, 0, 0, 0, 0, 1})
simIK.setObjectPose(env, second, {1.5, 0, 0, 0, 0, 0, 1})
simIK.setObjectPose(env, tip, {2, 0, 0, 0, 0, 0, 1})
simIK.setObjectParent(env, first, base, true)
simIK.setObjectParent(env, second, first, true)
simIK.setObjectParent(env, tip, second, true)
simIK.setJointPosition(env, second, 0.5)
simIK.setObjectPose(env, target, {1.4, 0.6, 0, 0, 0, 0, 1})
simIK.setTargetDummy(env, tip, target)
local group = simIK.createGroup(env)
simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 0.01, 100)
local element = simIK.addElement(env, group, tip)
simIK.setElementBase(env, group, element, base)
simIK.setElementConstraints(env, group, element, simIK.constraint_x + simIK.constraint_y)
"""


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> ScriptWorld:
    return ScriptWorld(tmp_path_factory.mktemp("own"))


def test_a_mechanism_made_in_an_environment_is_solved(world: ScriptWorld) -> None:
    place, code, after, joints = world.lua(
        TWO_LINKS
        + """
local place = simIK.getObjectPose(env, tip)
local code = simIK.handleGroup(env, group)
return place, code, simIK.getObjectPose(env, tip), simIK.getGroupJoints(env, group)[1] == first
"""
    )
    assert place[:3] == pytest.approx([1.5 + 0.5 * 0.87758, 0.5 * 0.47943, 0], abs=1e-4), (
        "its joint turns the tip"
    )
    assert (code, joints) == (1, True)
    assert after[:2] == pytest.approx([1.4, 0.6], abs=5e-4)


def test_the_jacobian_of_a_made_chain_is_that_of_its_group(world: ScriptWorld) -> None:
    code = """
local same = simIK.computeGroupJacobian(env, group)
return same, simIK.computeJacobian(env, base, second, 3, simIK.getObjectPose(env, tip))
"""
    same, rows, error = world.lua(TWO_LINKS + code)
    assert rows == pytest.approx(same)
    assert error == [0, 0]


def test_an_element_that_is_disabled_does_not_count(world: ScriptWorld) -> None:
    code = """
local other = simIK.createDummy(env)
simIK.setObjectPose(env, other, {0, 9, 0, 0, 0, 0, 1})
local end2 = simIK.createDummy(env)
simIK.setObjectPose(env, end2, simIK.getObjectPose(env, tip))
simIK.setObjectParent(env, end2, second, true)
simIK.setTargetDummy(env, end2, other)
local away = simIK.addElement(env, group, end2)
simIK.setElementBase(env, group, away, base)
local both = simIK.handleGroup(env, group)
simIK.setElementFlags(env, group, away, 0)
local flags = {simIK.getElementFlags(env, group, away), simIK.getElementFlags(env, group, element)}
return both, flags, simIK.handleGroup(env, group), simIK.getObjectPose(env, tip)
"""
    both, flags, alone, place = world.lua(TWO_LINKS + code)[:4]
    assert both != 1
    assert (flags, alone) == ([0, 1], 1)
    assert place[:2] == pytest.approx([1.4, 0.6], abs=5e-4)
    off = "simIK.setElementFlags(env, group, element, 0) simIK.handleGroup(env, group)"
    world.fails(TWO_LINKS + off, "the elements of the group .* are all disabled")


def test_coordinates_count_along_the_axes_of_another_object(world: ScriptWorld) -> None:
    code = """
local frame = simIK.createDummy(env)
simIK.setObjectPose(env, frame, {5, 5, 5, 0, 0, math.sin(math.pi / 8), math.cos(math.pi / 8)})
simIK.setElementBase(env, group, element, base, frame)
simIK.setElementConstraints(env, group, element, simIK.constraint_x)
local code = simIK.handleGroup(env, group)
local _, axes = simIK.getElementBase(env, group, element)
return code, axes == frame, simIK.getObjectPose(env, tip)
"""
    code, is_frame, place = world.lua(TWO_LINKS + code)
    assert (code, is_frame) == (1, True)
    gap = (place[0] - 1.4) + (place[1] - 0.6)  # along the diagonal, the frame's x axis
    assert abs(gap) < 1e-3
    assert abs(place[0] - 1.4) > 0.02  # the other coordinate is free


def test_passive_joints_limits_and_slides_count(world: ScriptWorld) -> None:
    code, first, slide = world.lua(
        TWO_LINKS
        + """
simIK.setJointMode(env, second, simIK.jointmode_passive)
local slide = simIK.createJoint(env, simIK.jointtype_prismatic)
simIK.setObjectPose(env, slide, {1.5, 0, 0, 0, 0.70710678, 0, 0.70710678})
simIK.setObjectParent(env, slide, second, true)
simIK.setObjectParent(env, tip, slide, true)
simIK.setJointInterval(env, slide, false, {0, 0.1})
local code = simIK.handleGroup(env, group)
return code, simIK.getJointPosition(env, first), simIK.getJointPosition(env, slide)
"""
    )
    assert code == 2, "the target is 0.72 m from the base, and the slide ends at 0.1 m"
    assert 0 <= slide <= 0.1
    assert first != 0


def test_flags_of_a_group_hold_back_what_misses(world: ScriptWorld) -> None:
    before, code, kept, off, moved, flags = world.lua(
        TWO_LINKS
        + """
simIK.setObjectPose(env, target, {9, 9, 0, 0, 0, 0, 1})
local flags = simIK.getGroupFlags(env, group)
local before = simIK.getJointPosition(env, first)
simIK.setGroupFlags(env, group, 1 + 2 + 4 + 8)
local code = simIK.handleGroup(env, group)
local kept = simIK.getJointPosition(env, first)
simIK.setGroupFlags(env, group, 0)
local off = simIK.handleGroup(env, group)
simIK.setGroupFlags(env, group, simIK.group_enabled)
simIK.handleGroup(env, group)
return before, code, kept, off, simIK.getJointPosition(env, first), flags
"""
    )
    assert (code, kept, off, flags) == (2, before, 0, 3)
    assert abs(moved - before) > 0.1


def test_joints_keep_margins_where_limits_are_avoided(world: ScriptWorld) -> None:
    free, kept, asked = world.lua(
        TWO_LINKS
        + """
simIK.setObjectPose(env, target, {-9, 9, 0, 0, 0, 0, 1})
simIK.setJointInterval(env, second, false, {0, 2})
simIK.setJointLimitMargin(env, second, 0.25)
simIK.setJointInterval(env, first, false, {-0.3, 0.6})
simIK.setJointLimitMargin(env, first, 0.1)
simIK.handleGroup(env, group)
local free = simIK.getJointPosition(env, first)
simIK.setGroupFlags(env, group, simIK.group_enabled + simIK.group_avoidlimits)
simIK.handleGroup(env, group)
return free, simIK.getJointPosition(env, first), {simIK.getJointLimitMargin(env, first),
    simIK.getJointLimitMargin(env, second), simIK.getJointMaxStepSize(env, first), simIK.doesGroupExist(env, 'x'),
    simIK.doesIkGroupExist(env, 'group1')}
"""
    )
    assert (free, kept) == (pytest.approx(0.3, abs=1e-3), pytest.approx(0.2, abs=1e-3))
    assert asked == [0.1, 0.25, pytest.approx(0.17453, abs=1e-4), False, True]


def test_objects_that_are_made_are_listed_and_erased(world: ScriptWorld) -> None:
    kinds, listed, link, after, parent = world.lua(
        TWO_LINKS
        + """
local kinds = {simIK.getObjectType(env, first), simIK.getObjectType(env, tip), simIK.getJointType(env, first)}
local handle, name, isJoint, kind = simIK.getObjects(env, 3)
local listed = {handle == first, name, isJoint, kind, simIK.getObjectHandle(env, 'goal') == target}
local link = simIK.getTargetDummy(env, tip) == target
local extra = simIK.createDummy(env)
simIK.setObjectParent(env, second, extra)
simIK.setObjectParent(env, extra, first)
simIK.eraseObject(env, extra)
return kinds, listed, link, simIK.getObjects(env, 5), simIK.getObjectParent(env, second) == first
"""
    )
    assert (kinds, listed) == ([1, 4, 10], [True, "first", True, 10, True])
    assert (link, after, parent) == (True, None, True)


def test_what_was_set_can_be_asked(world: ScriptWorld) -> None:
    base, constraints, precision, weights, joint, old = world.lua(
        TWO_LINKS
        + """
simIK.setElementPrecision(env, group, element, {0.01, 0.02})
simIK.setElementWeights(env, group, element, {1, 0.5})
simIK.setJointWeight(env, second, 0.25)
local base, axes = simIK.getElementBase(env, group, element)
simIK.setLinkedDummy(env, base, target)
local old = simIK.addIkElement(env, simIK.createGroup(env), tip)
simIK.setIkElementBase(env, 2, old, first)
return base == axes, simIK.getElementConstraints(env, group, element),
    simIK.getElementPrecision(env, group, element), simIK.getElementWeights(env, group, element),
    {simIK.getJointWeight(env, first), simIK.getJointWeight(env, second), simIK.getLinkedDummy(env, base) == target},
    {simIK.getGroupJoints(env, 2)[1] == second, #simIK.getGroupJoints(env, 2)}
"""
    )
    assert (base, constraints, precision, weights) == (True, 3, [0.01, 0.02], [1, 0.5])
    assert (joint, old) == ([1, 0.25, True], [True, 1])


def test_own_objects_follow_an_object_of_the_scene_that_carries_them(world: ScriptWorld) -> None:
    code, place = world.lua(
        TWO_LINKS
        + """
local cube = sim.getObject('/cube')
simIK.setObjectParent(env, base, cube, false)
simIK.setObjectPose(env, target, {3.4, 0.6, 1, 0, 0, 0, 1})
local code = simIK.handleGroup(env, group, {syncWorlds = true})
return code, simIK.getObjectPose(env, base, cube)
"""
    )
    assert code == 1
    assert place[:3] == pytest.approx([1, 0, 0])


@pytest.mark.parametrize(
    ("source", "text"),
    [
        ("simIK.createJoint(env, simIK.jointtype_spherical)", "is no type of joint that can be made"),
        ("simIK.setObjectParent(env, base, tip)", "'base' cannot lie below itself"),
        ("simIK.setObjectParent(env, base, 12345)", "12345"),
        ("simIK.setElementBase(env, group, element, target)", "'goal' is not above"),
        ("simIK.addElement(env, group, base)", "has no target"),
        (
            "simIK.setTargetDummy(env, base, target) simIK.addElement(env, group, base)",
            "no joint that was made",
        ),
        ("simIK.eraseObject(env, target)", "needs 'goal'"),
        ("simIK.setJointPosition(env, tip, 1)", "is a dummy, not a joint"),
    ],
)
def test_mistakes_say_what_is_wrong(world: ScriptWorld, source: str, text: str) -> None:
    world.fails(TWO_LINKS + source, text)


def test_values_out_of_range_are_brought_into_it_as_in_coppeliasim(world: ScriptWorld) -> None:
    world.lua(TWO_LINKS + "simIK.setJointWeight(env, first, -1) simIK.setJointLimitMargin(env, first, -1)")
    assert world.lua(
        TWO_LINKS + "simIK.setJointMaxStepSize(env, first, 0) return simIK.handleGroup(env, group)"
    )
    assert world.lua(
        TWO_LINKS + "simIK.setGroupFlags(env, group, 17) return simIK.getGroupFlags(env, group)"
    ) == [1]
    world.lua(TWO_LINKS + "simIK.setObjectParent(env, sim.getObject('/cube'), base)")
    assert "keeps its parent" in world.parts.status_bar.messages[-1]


def test_an_element_is_given_by_its_tip(world: ScriptWorld) -> None:
    source = "simIK.setElementConstraints(env, group, tip | simIK.handleflag_tipdummy, 0) "
    source += "return simIK.getElementConstraints(env, group, element), simIK.handleGroup(env, group)"
    assert world.lua(TWO_LINKS + source)[:2] == [0, 1]  # without constraints there is nothing to miss


def test_weights_and_step_sizes_change_the_way(world: ScriptWorld) -> None:
    ways = [
        world.lua(TWO_LINKS + setting + MOVED)[0]
        for setting in ("", "simIK.setJointWeight(env, first, 0.01)", SMALL_STEPS)
    ]
    plain, heavy, small = ways
    assert heavy < plain / 2
    assert small == pytest.approx(0.001, abs=1e-6)


MOVED = """
simIK.setElementConstraints(env, group, element, simIK.constraint_y)
simIK.setGroupCalculation(env, group, simIK.method_damped_least_squares, 0.01, 1)
simIK.handleGroup(env, group)
return math.abs(simIK.getJointPosition(env, first))
"""
SMALL_STEPS = "simIK.setGroupFlags(env, group, 1) simIK.setJointMaxStepSize(env, first, 0.001)"


def test_joints_tell_what_they_move_and_follow(world: ScriptWorld) -> None:
    matrix, (place, quat, euler), followed, lead = world.lua(
        TWO_LINKS
        + """
local slide = simIK.createJoint(env, simIK.jointtype_prismatic)
simIK.setJointPosition(env, slide, 0.25)
simIK.setJointScrewLead(env, slide, 0)
simIK.setJointDependency(env, second, -1)
return simIK.getJointMatrix(env, slide), {simIK.getJointTransformation(env, second)},
    {simIK.getJointDependency(env, second)}, simIK.getJointScrewLead(env, slide)
"""
    )
    assert matrix == [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.25]
    assert place == [0, 0, 0]
    assert quat == pytest.approx([0, 0, 0.247404, 0.968912], abs=1e-6)
    assert euler == pytest.approx([0, 0, 0.5])
    assert (followed, lead) == ([-1, 0, 1], 0)
    world.lua(TWO_LINKS.replace("local ", ""))
    world.goes_on("simIK.setJointScrewLead(env, first, 0.1)", "are not screws", 1)
    world.goes_on(
        "simIK.setJointDependency(env, second, first, 0, 2)", "follows another one as in the scene", 1
    )


def test_joints_at_a_limit_are_told_of(world: ScriptWorld) -> None:
    hits, beyond, same = world.lua(
        TWO_LINKS
        + """
simIK.setJointInterval(env, second, false, {0.4, 0.2})
simIK.handleIkGroups(env, {group})
local hits, beyond = simIK.getGroupJointLimitHits(env, group)
return #hits, #beyond, hits[1] == second
"""
    )
    assert (hits, beyond, same) == (1, 1, True)
