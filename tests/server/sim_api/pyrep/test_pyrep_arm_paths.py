"""Paths of arms that PyRep's add-on plans: around obstacles, from the start to a goal, the same in every run."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from scenes_for_tests import NoRendering
from sim_api_calls import ScriptWorld

from simx_server.app.building import build_world
from simx_server.errors import CommandError
from simx_server.kinematics.planning.validity import Validity
from simx_server.kinematics.searching import Searching
from simx_server.scene.formats.loader import load_text
from simx_server.sim_api.planning.ompl import ALGORITHMS
from simx_server.world.world import World

pytestmark = pytest.mark.slow

_AXES = ("0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1")
_REACHES = (0.3, 0.15, 0.15, 0.2, 0.15, 0.1, 0.08)
"""Metres along the arm from each joint to the next one."""


def _arm() -> str:
    text = ""
    for number, (axis, reach) in enumerate(zip(_AXES, _REACHES, strict=True), 1):
        place = _REACHES[number - 2] if number > 1 else 0.1
        text += (
            f'<body pos="0 0 {place}"><joint name="joint{number}" axis="{axis}" range="-2.8 2.8"/>'
            f'<geom type="capsule" fromto="0 0 0.04 0 0 {reach - 0.02}" size="0.03" mass="0.5"/>'
        )
    return text + "</body>" * len(_AXES)


SCENE = f"""
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1"/>
    <body name="base"><geom type="cylinder" size=".06 .05" pos="0 0 .05"/>{_arm()}</body>
    <body name="box" pos=".45 0 .45"><geom type="box" size=".12 .12 .25"/></body>
  </worldbody>
  <custom><text name="simx:collection:arm" data="tree=base"/></custom>
</mujoco>
"""
"""Seven joints as of usual arms. The arm leans forward, and the box is where it turns from side to side."""

LEFT = [-0.9, 1.2, 0.0, 0.5, 0.0, 0.3, 0.0]
RIGHT = [0.9, 1.2, 0.0, 0.5, 0.0, 0.3, 0.0]
MIDDLE = [0.0, 1.2, 0.0, 0.5, 0.0, 0.3, 0.0]
JOINTS = [f"joint{number}" for number in range(1, 8)]

FLAT = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="base"><geom type="cylinder" size=".05 .2" pos="0 0 .2"/>
      <body name="upper" pos="0 0 .5"><joint name="shoulder" axis="0 0 1" range="-3 -1" limited="true"/>
        <geom type="capsule" fromto=".1 0 0 .4 0 0" size=".03" mass="1"/>
        <body name="lower" pos=".4 0 0"><joint name="wheel" axis="1 0 0" limited="false"/>
          <geom type="box" size=".02 .02 .02" pos=".1 0 0" mass=".1"/></body>
      </body>
    </body>
    <body name="post" pos="{post} .5"><geom type="box" size=".04 .04 .3"/></body>
  </worldbody>
  <custom>
    <text name="simx:collection:arm" data="tree=base"/>
    <text name="simx:joint:wheel" data="cyclic=yes"/>
  </custom>
</mujoco>
"""
"""Two joints: one with limits -3 and -1, and one without an end."""

FREE, IN_THE_WAY = "2 2", "-.15 -.37"
"""Places of the post."""


class Place:
    """A world, and the calls of its add-on."""

    def __init__(self, text: str, names: Sequence[str], start: Sequence[float], seed: int = 0) -> None:
        self.world: World = build_world(NoRendering(), searching=Searching(seed))  # type: ignore[arg-type]
        self.world.simulation.use(*load_text(text))
        self.sim = self.world.simulation
        self.joints = [self.sim.scene.resolve(name) for name in names]
        self.arm = self.world.collections.find("arm")
        self.put(start)

    def put(self, values: Sequence[float]) -> None:
        for handle, value in zip(self.joints, values, strict=True):
            self.sim.joints.set_position(handle, value)

    def collides(self, values: Sequence[float], other: str = "box") -> bool:
        self.put(values)
        assert self.arm is not None
        return bool(self.world.meters.collisions.check(self.arm, self.sim.scene.resolve(other)))

    def plan(
        self, *goals: Sequence[float], trials: int = 1, ignores: int = 0, name: str = "RRTConnect"
    ) -> np.ndarray:
        values = [value for goal in goals for value in goal]
        found = self.call([self.arm, ignores, trials, *self.joints], values, [name])
        assert (found[0], found[2], found[3]) == ([], [], b"")
        return np.array(found[1]).reshape(-1, len(self.joints))

    def call(self, ints: list[Any], floats: list[float], strings: list[str]) -> Any:
        return self.world.scripts.add_ons["PyRep"].call("getNonlinearPath", ints, floats, strings, b"")


@pytest.fixture
def lab() -> Place:
    return Place(SCENE, JOINTS, LEFT)


def flat(post: str = FREE, start: Sequence[float] = (-2.0, 0.0)) -> Place:
    return Place(FLAT.format(post=post), ("shoulder", "wheel"), start)


@pytest.fixture
def count_checks(monkeypatch: pytest.MonkeyPatch) -> Callable[[], int]:
    """Returns how many states were checked for collisions since the start of the test."""
    checked = [0]
    check = Validity.at

    def counting(self: Validity, *arguments: Any) -> bool:
        checked[0] += 1
        return check(self, *arguments)

    monkeypatch.setattr(Validity, "at", counting)
    return lambda: checked[0]


def length(path: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def test_an_arm_of_seven_joints_goes_around_a_box_from_its_place_to_the_goal(lab: Place) -> None:
    before = lab.sim.data.qpos.copy()
    path = lab.plan(RIGHT)
    assert np.array_equal(lab.sim.data.qpos, before), "nothing moves"
    assert len(path) >= 300
    assert path[0] == pytest.approx(LEFT)
    assert path[-1] == pytest.approx(RIGHT)
    assert np.abs(np.diff(path, axis=0)).max() < 0.1
    assert lab.collides(MIDDLE)
    assert not any(lab.collides(state) for state in path)


def test_a_plan_of_seven_joints_needs_few_checks(lab: Place, count_checks: Callable[[], int]) -> None:
    assert len(lab.plan(RIGHT))
    assert count_checks() < 3000


def test_equal_programs_get_equal_paths_and_another_seed_gives_another() -> None:
    def paths(seed: int) -> list[np.ndarray]:
        place = Place(SCENE, JOINTS, LEFT, seed)
        found = []
        for _ in range(2):
            place.sim.start()
            found += [place.plan(RIGHT), place.plan(RIGHT)]
            place.sim.stop()
        return found

    first, again, other = paths(0), paths(0), paths(7)
    for a, b in zip(first, again, strict=True):
        assert np.array_equal(a, b)
    assert np.array_equal(first[0], first[2]), "a run starts with the same numbers"
    assert not np.array_equal(first[0], other[0])


def test_more_trials_give_no_longer_path(lab: Place) -> None:
    one = lab.plan(RIGHT)
    lab = Place(SCENE, JOINTS, LEFT)
    assert length(lab.plan(RIGHT, trials=10)) <= length(one) + 1e-9


def test_a_free_straight_line_ends_the_trials(lab: Place, count_checks: Callable[[], int]) -> None:
    goal = [-1.5, 0.9, 0.2, 0.5, 0.0, 0.3, 0.5]
    path = lab.plan(goal, trials=100)
    assert length(path) == pytest.approx(math.dist(LEFT, goal))
    assert count_checks() < 500


def test_the_nearest_goal_that_is_free_is_chosen(lab: Place) -> None:
    near = [-1.4, 1.2, 0.0, 0.5, 0.0, 0.3, 0.0]
    assert lab.plan(RIGHT, near)[-1] == pytest.approx(near)
    assert lab.plan(MIDDLE, near)[-1] == pytest.approx(near)


def test_a_goal_within_an_obstacle_gives_nothing(lab: Place, count_checks: Callable[[], int]) -> None:
    assert len(lab.plan(MIDDLE, trials=10)) == 0
    assert count_checks() < 10


def test_a_start_within_an_obstacle_gives_nothing(lab: Place) -> None:
    lab.put(MIDDLE)
    assert len(lab.plan(RIGHT, trials=10)) == 0


def test_where_there_is_no_way_nothing_comes_after_a_counted_effort(
    count_checks: Callable[[], int],
) -> None:
    place = flat(IN_THE_WAY, (-1.1, 0.0))
    assert place.collides((-2.0, 0.0), "post")
    place.put((-1.1, 0.0))
    assert len(place.plan((-2.9, 0.0))) == 0
    once = count_checks()
    assert len(place.plan((-2.9, 0.0), trials=1000)) == 0
    assert once < 9_000
    assert count_checks() - once < 30_000


def test_ignored_collisions_leave_the_straight_line(lab: Place) -> None:
    path = lab.plan(RIGHT, ignores=1)
    assert len(path) == 300
    assert length(path) == pytest.approx(math.dist(LEFT, RIGHT))
    assert path[150, 1:] == pytest.approx(LEFT[1:])


def test_the_upper_bound_of_a_joint_is_its_least_value_and_its_range() -> None:
    place = flat()
    assert len(place.plan((-1.0, 0.0))), "single precision may pass the limit by little"
    assert len(place.plan((-0.9, 0.0))) == 0, "PyRep takes the range, 2, as the upper bound"
    assert len(place.plan((-3.1, 0.0))) == 0


def test_a_joint_without_an_end_goes_the_short_way_and_never_jumps() -> None:
    place = flat(start=(-2.0, 3.0))
    path = place.plan((-1.5, -3.0))
    assert np.abs(np.diff(path, axis=0)).max() < 0.1
    assert path[-1] == pytest.approx([-1.5, 2 * math.pi - 3.0])


@pytest.mark.parametrize("name", ALGORITHMS)
def test_all_names_of_algorithms_are_known(name: str) -> None:
    assert len(flat().plan((-1.5, 1.0), name=name)) == 300


def test_wrong_arguments_are_explained(lab: Place) -> None:
    with pytest.raises(CommandError, match="no algorithm; did you mean 'RRTConnect'"):
        lab.plan(RIGHT, name="RRTConect")
    with pytest.raises(CommandError, match="7 numbers each, one for each joint, not 6"):
        lab.plan(RIGHT[:6])
    with pytest.raises(CommandError, match="7 numbers each"):
        lab.plan()
    with pytest.raises(CommandError, match="at most 1000 goals are tried, not 1001"):
        lab.plan(*[RIGHT] * 1001)
    with pytest.raises(CommandError, match="not finite"):
        lab.plan([*RIGHT[:6], math.nan])
    with pytest.raises(CommandError, match="takes a collection"):
        lab.call([lab.arm, 0, 1], RIGHT, ["RRTConnect"])
    with pytest.raises(CommandError, match="listed twice"):
        lab.call([lab.arm, 0, 1, lab.joints[0], lab.joints[0]], [0.0, 0.0], ["RRTConnect"])
    with pytest.raises(CommandError, match="no object with handle 999"):
        lab.call([lab.arm, 0, 1, 999], [0.0], ["RRTConnect"])


def test_programs_call_the_add_on_by_its_name(tmp_path: Any) -> None:
    world = ScriptWorld(tmp_path, FLAT.format(post=FREE), owner="base")
    handles = "{sim.getCollectionHandle('arm'), 0, 1, sim.getObject('/shoulder'), sim.getObject('/wheel')}"
    ints, path, texts, buffer = world.lua(
        f"return sim.callScriptFunction('getNonlinearPath@PyRep', 2, {handles}, {{-1.5, 1}}, {{'SBL'}}, '')"
    )
    assert (ints, len(path), texts, buffer) == ([], 600, [], "")
    world.fails("sim.callScriptFunction('getPath@PyRep', 2)", "has no function 'getPath'; it has: getNonlin")
    scene = world.sim.scene
    joints = [scene.resolve("shoulder"), scene.resolve("wheel")]
    arm = world.parts.collections.find("arm")
    found = world.call(
        "simxCallScriptFunction",
        "PyRep",
        2,
        "getNonlinearPath",
        [arm, 0, 1, *joints],
        [-1.5, 1.0],
        ["SBL"],
        b"",
    )
    assert len(found[1]) == 600
