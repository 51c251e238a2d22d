"""Grippers hold what they have grasped by force: the fast rows of docs/grasps.md."""

from __future__ import annotations

from pathlib import Path

import pytest
from checkouts import PYREP_GRIPPERS, RLBENCH, model_of_rlbench, needs_pyrep

from bench.grasps.arms import ARMS, swing
from bench.grasps.grippers import GRIPPERS, PANDA
from bench.grasps.program import Program
from bench.grasps.things import THINGS, Thing
from bench.grasps.trial import Held, trial
from bench.motion.__main__ import SCENES

pytestmark = pytest.mark.slow

SECONDS = 3.0

PADS = """
<mujoco>
  <include file="{parts}/settings.xml"/>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="lift" type="slide" axis="0 0 1"/>
      <geom type="box" size="0.02 0.02 0.02" mass="1" contype="0" conaffinity="0"/>
      <body name="pad" pos="0 0 -0.1">
        <geom type="cylinder" size="0.02 0.005" mass="0.02" margin="0.002" gap="0.002"/>
      </body>
    </body>
    <body name="box" pos="0 0 0.8449"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="0.5"/></body>
  </worldbody>
  <actuator>
    <general body="pad" biastype="affine" biasprm="{force} 0 0"/>
  </actuator>
  <custom>
    <text name="simx:joint:lift" data="mode=force motor=on control=velocity rigid=yes max_force=1000"/>
  </custom>
</mujoco>"""


def _box(name: str) -> Thing:
    return next(thing for thing in THINGS if thing.name == name)


def _hold(gripper: str, thing: Thing, **keywords: object) -> Held:
    return trial(GRIPPERS[gripper], thing, PYREP_GRIPPERS, RLBENCH / "task_ttms", seconds=SECONDS, **keywords)  # pyright: ignore[reportArgumentType]


@needs_pyrep
@pytest.mark.parametrize("gripper", GRIPPERS)
def test_a_gripper_of_pyrep_carries_a_box_upside_down(gripper: str) -> None:
    held = _hold(gripper, _box("box of 500 g"))
    assert not held.lost
    assert held.slip < 1.5
    assert held.turn < 3
    assert held.creep < 0.1


@needs_pyrep
def test_a_gripper_holds_a_block_of_a_task_after_its_motors_have_stopped() -> None:
    block = Thing("pick_and_lift_target", model_of_rlbench("task_ttms/pick_and_lift.ttm").name)
    held = _hold("Panda", block, keeps_closing=False)
    assert not held.lost
    assert held.slip < 0.2
    assert held.aside < 0.5, "the motors are locked at velocity 0"


@needs_pyrep
def test_a_gripper_keeps_its_box_while_the_program_adds_shapes() -> None:
    def add_a_shape(program: Program) -> None:
        shape = program.call("createPureShape", 0, 8, [0.1] * 3, 0.1)
        program.place(shape, (3.0, 0.0, 0.1))

    plain, edited = (_hold("Mico", _box("box of 500 g"), each_second=each) for each in (None, add_a_shape))
    assert not edited.lost
    assert edited.creep == pytest.approx(plain.creep, abs=0.02)


def test_an_arm_of_rlbench_swings_its_box() -> None:
    robots = model_of_rlbench("robot_ttms/panda.ttm").parent
    held = swing(ARMS["Panda"], robots, seconds=SECONDS)
    assert not held.lost
    assert held.slip < 0.2
    assert held.turn < 0.5
    assert held.creep < 0.1


def test_the_panda_closes_along_x_of_the_world() -> None:
    turn = PANDA.turned_down()
    assert (turn @ PANDA.across).tolist() == [1.0, 0.0, 0.0]
    assert (turn @ PANDA.forwards).tolist() == [0.0, 0.0, -1.0]


def test_shipped_scenes_have_the_friction_of_imported_ones() -> None:
    with Program("empty") as program:
        assert program.call("getEngineFloatParameter", 37002, -1) == 100.0


@pytest.mark.parametrize(("force", "lifted"), [(20, True), (2, False)])
def test_a_pad_lifts_a_box_by_adhesion_if_it_is_strong_enough(
    tmp_path: Path, force: float, lifted: bool
) -> None:
    scene = tmp_path / "pads.xml"
    scene.write_text(PADS.format(parts=(SCENES / "parts").as_posix(), force=force))
    with Program(str(scene)) as program:
        program.call("startSimulation")
        lift, pad, box = (program.handle(name) for name in ("lift", "pad", "box"))
        for number in range(100):
            program.call("setJointTargetVelocity", lift, 0.2 if number < 20 else 0.0)
            program.step()
        distance = abs(float(program.pose(box, pad)[2, 3]))
    assert (distance < 0.058) == lifted, "the margin of the pad is 2 mm"
