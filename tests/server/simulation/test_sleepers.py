"""Bodies that MuJoCo lets sleep: no client notices, but for the time that a step takes."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
from real_world import BLOCKING, Open, RealWorld, handle_of, start_stepped, step
from scripted_world import scripted

import simx_client as v

SCENE = """
<mujoco>
  <option timestep="0.002">{flag}</option>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="table" pos="2 0 0.1"><geom name="top" type="box" size="0.2 0.2 0.1"/></body>
    <body name="below" pos="0 0 0.05"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
    <body name="above" pos="0 0 0.15"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
    <body name="on_table" pos="2 0 0.25"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
  </worldbody>
</mujoco>
"""
SLEEP = '<flag sleep="enable"/>'


def at_rest(world: Open, folder: Path, flag: str = SLEEP) -> tuple[RealWorld, int]:
    path = folder / f"rest{len(flag)}.xml"
    path.write_text(SCENE.format(flag=flag))
    opened, client = world(str(path))
    start_stepped(client)
    step(client, 2)
    return opened, client


def asleep(opened: RealWorld) -> int:
    return int(np.sum(opened.simulation.data.tree_asleep >= 0))


def height(client: int, name: str) -> float:
    code, position = v.simxGetObjectPosition(client, handle_of(client, name), -1, BLOCKING)
    assert code == 0
    return position[2]


def test_what_lies_still_sleeps_and_a_step_computes_no_contact_of_it(world: Open, tmp_path: Path) -> None:
    opened, _ = at_rest(world, tmp_path)
    assert asleep(opened) == 3
    assert opened.simulation.data.ncon == 0


def test_its_contacts_and_their_forces_are_told_all_the_same(world: Open, tmp_path: Path) -> None:
    found = []
    for flag in (SLEEP, ""):
        opened, client = at_rest(world, tmp_path, flag)
        below = handle_of(client, "below")
        found.append([(one.objects, one.force[2]) for one in opened.parts.contacts.find(None, below)])
    assert [objects for objects, _ in found[0]] == [objects for objects, _ in found[1]]
    assert sum(force for _, force in found[0]) == pytest.approx(sum(force for _, force in found[1]), rel=1e-3)
    assert asleep(opened) == 0  # the one without the flag, for comparison


def test_asking_for_contacts_wakes_nobody(world: Open, tmp_path: Path) -> None:
    opened, client = at_rest(world, tmp_path)
    assert opened.parts.contacts.find(None)
    step(client, 0.05)
    assert asleep(opened) == 3


def test_an_object_that_is_lifted_falls(world: Open, tmp_path: Path) -> None:
    opened, client = at_rest(world, tmp_path)
    above = handle_of(client, "above")
    v.simxSetObjectPosition(client, above, -1, (0, 0, 0.5), BLOCKING)
    step(client, 0.1)
    assert height(client, "above") < 0.49
    step(client, 2)
    assert height(client, "above") == pytest.approx(0.15, abs=1e-3)
    assert asleep(opened) == 3


def test_what_lay_on_an_object_that_is_taken_away_falls(world: Open, tmp_path: Path) -> None:
    _, client = at_rest(world, tmp_path)
    v.simxSetObjectPosition(client, handle_of(client, "below"), -1, (1, 0, 0.05), BLOCKING)
    step(client, 1)
    assert height(client, "above") == pytest.approx(0.05, abs=1e-3)


def test_what_lay_on_a_removed_object_falls(world: Open, tmp_path: Path) -> None:
    _, client = at_rest(world, tmp_path)
    assert v.simxRemoveObject(client, handle_of(client, "below"), BLOCKING) == 0
    step(client, 1)
    assert height(client, "above") == pytest.approx(0.05, abs=1e-3)


def test_what_lies_on_a_static_object_goes_down_with_it(world: Open, tmp_path: Path) -> None:
    _, client = at_rest(world, tmp_path)
    v.simxSetObjectPosition(client, handle_of(client, "table"), -1, (2, 0, -0.05), BLOCKING)
    step(client, 1)
    assert height(client, "on_table") == pytest.approx(0.10, abs=1e-3)


def test_other_gravity_moves_what_slept(world: Open, tmp_path: Path) -> None:
    opened, client = at_rest(world, tmp_path)
    v.simxSetArrayParameter(client, v.sim_arrayparam_gravity, (0, 0, 1), BLOCKING)
    step(client, 0.5)
    assert height(client, "above") > 0.2
    assert not opened.simulation.data.xfrc_applied.any()


def test_a_run_after_a_stop_is_equal_bit_for_bit(world: Open, tmp_path: Path) -> None:
    opened, client = at_rest(world, tmp_path)
    states = []
    for _ in range(2):
        v.simxStopSimulation(client, BLOCKING)
        start_stepped(client)
        step(client, 1)
        v.simxSetObjectPosition(client, handle_of(client, "above"), -1, (0.02, 0, 0.3), BLOCKING)
        step(client, 1)
        size = mujoco.mj_stateSize(opened.simulation.model, mujoco.mjtState.mjSTATE_INTEGRATION)
        state = np.zeros(size)
        mujoco.mj_getState(
            opened.simulation.model, opened.simulation.data, state, mujoco.mjtState.mjSTATE_INTEGRATION
        )
        states.append(state)
    assert np.array_equal(*states)


@pytest.mark.parametrize(("name", "place"), [("above", (0.5, 0.0, 0.4)), ("table", (2.0, 0.0, 0.3))])
def test_where_something_is_put_is_read_at_once(
    world: Open, tmp_path: Path, name: str, place: tuple[float, float, float]
) -> None:
    _, client = at_rest(world, tmp_path)
    handle = handle_of(client, name)
    v.simxSetObjectPosition(client, handle, -1, place, BLOCKING)
    assert v.simxGetObjectPosition(client, handle, -1, BLOCKING)[1] == pytest.approx(place)


def test_where_mujoco_cannot_wake_nothing_sleeps(world: Open, tmp_path: Path) -> None:
    opened, client = at_rest(world, tmp_path)
    (tmp_path / "tied.xml").write_text("""
        <mujoco>
          <worldbody>
            <body name="tied">
              <joint name="left" axis="1 0 0"/><joint name="right" axis="0 1 0"/><geom size="0.1" pos="0 0 5"/>
            </body>
          </worldbody>
          <tendon>
            <fixed name="one"><joint joint="left" coef="1"/></fixed>
            <fixed name="two"><joint joint="right" coef="1"/></fixed>
          </tendon>
          <equality><tendon tendon1="one" tendon2="two"/></equality>
        </mujoco>""")
    opened.simulation.files.more_folders = [tmp_path]
    assert v.simxLoadModel(client, str(tmp_path / "tied.xml"), 0, BLOCKING)[0] == 0
    step(client, 1)
    assert asleep(opened) == 0


SCALE = """
<mujoco>
  <option timestep="0.002"><flag sleep="enable"/></option>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="scale" pos="0 0 0.1"><geom type="box" size="0.2 0.2 0.01"/>
      <body name="plate" pos="0 0 0.05"><geom type="box" size="0.2 0.2 0.02" mass="1"/>
        <site name="cell" pos="0 0 -0.02"/></body></body>
    <body name="load" pos="0 0 0.22"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="2"/></body>
    <body name="arm" pos="2 0 1" sleep="allowed"><joint name="elbow" axis="0 1 0" damping="0.1"/>
      <geom type="box" size="0.02 0.02 0.02" pos="0.1 0 0" mass="0.1"/></body>
  </worldbody>
  <sensor>{sensors}</sensor>
  <custom><text name="simx:joint:elbow" data="mode=force motor=yes control=position"/></custom>
</mujoco>
"""


def test_a_scale_tells_the_weight_of_what_lies_still_on_it(world: Open, tmp_path: Path) -> None:
    path = tmp_path / "scale.xml"
    path.write_text(SCALE.format(sensors='<force site="cell"/><torque site="cell"/>'))
    _, client = world(str(path))
    start_stepped(client)
    step(client, 3)
    code, _, force, _ = v.simxReadForceSensor(client, handle_of(client, "cell"), BLOCKING)
    assert code == 0
    assert force[2] == pytest.approx(-3 * 9.81, rel=1e-2)


def test_a_driven_joint_never_sleeps_whatever_the_file_says(world: Open, tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(SCALE.format(sensors=""))
    opened, client = world(str(path))
    start_stepped(client)
    step(client, 3)
    assert asleep(opened) == 1  # the load
    elbow = handle_of(client, "elbow")
    v.simxSetJointTargetPosition(client, elbow, 0.3, BLOCKING)
    step(client, 1)
    assert v.simxGetJointPosition(client, elbow, BLOCKING)[1] == pytest.approx(0.3, abs=0.1)


WATCHED = """
<geom name="floor" type="plane" size="5 5 0.1"/>
<body name="table" pos="2 0 0.1"><geom name="top" type="box" size="0.2 0.2 0.1"/></body>
<body name="on_table" pos="2 0 0.25"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
<body name="host" pos="0 1 5"><geom size="0.01" contype="0" conaffinity="0"/></body>
"""
DECIDES = """
n = 0
function sysCall_actuation() n = n + 1 end
function sysCall_contactCallback(inData)
    if n > 30 then return {ignoreContact = false, collisionResponse = false} end
end
"""
TAKES_AWAY = """
n = 0
function sysCall_actuation() n = n + 1 end
function sysCall_dynCallback(inData)
    if n == 30 and inData.afterStep and inData.passCnt == 1 then
        sim.setObjectPosition(sim.getObjectHandle('table'), -1, {2, 0, -1})
    end
end
"""


@pytest.mark.parametrize(("script", "passes"), [(DECIDES, 32), (TAKES_AWAY, 30)])
def test_what_scripts_do_between_physics_steps_acts_on_what_lay_still(script: str, passes: int) -> None:
    pytest.importorskip("lupa")
    fallen = []
    for flag in (True, False):
        scene = scripted({"lua:host": script}, body=WATCHED)
        scene.sim.model.opt.gravity[2] = -9.81
        if flag:
            scene.sim.model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
        scene.run(passes)
        fallen.append(scene.call("simxGetObjectPosition", scene.handle("on_table"), -1)[2])
        scene.sim.stop()
    assert fallen[0] < 0.249
    assert fallen[0] == pytest.approx(fallen[1], abs=1e-6)
