"""A new run from a past step: the world is what it was, and goes on as if it had never been interrupted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from past_lab import MACHINE, Lab
from real_world import BLOCKING

import simx_client as v
from simx_server.errors import CommandError
from simx_server.history import going_on
from simx_server.recording import state
from simx_server.service.ending import QuitAfterStop
from simx_server.viewer.feed import Feed


def driving(lab: Lab) -> Callable[[int], None]:
    """A client that moves the arm, changes a controller, and sets signals, at given steps."""
    shoulder, elbow, spin = lab.handle("shoulder"), lab.handle("elbow"), lab.handle("spin")

    def act(step: int) -> None:
        if step % 7 == 0:
            v.simxSetJointTargetPosition(lab.client, elbow, 0.1 * (step % 5), BLOCKING)
        if step == 3:
            v.simxSetJointTargetPosition(lab.client, shoulder, -0.7, BLOCKING)
            v.simxSetFloatSignal(lab.client, "gain", 0.5, BLOCKING)
        if step == 11:
            v.simxSetJointForce(lab.client, elbow, 4.0, BLOCKING)
            v.simxSetJointTargetVelocity(lab.client, spin, 2.0, BLOCKING)
        if step == 30:
            v.simxSetJointForce(lab.client, elbow, 15.0, BLOCKING)
            v.simxSetStringSignal(lab.client, "phase", b"late", BLOCKING)

    return act


@pytest.mark.parametrize("step", [0, 1, 12, 25])
def test_a_run_goes_on_bit_for_bit_as_if_it_had_not_been_interrupted(
    open_lab: Callable[[str], Lab], step: int
) -> None:
    lab = open_lab(MACHINE)
    act = driving(lab)
    lab.start()
    first = lab.run_to(40, act)
    lab.go_on(step)
    lab.start()
    assert lab.run_to(40, act) == first[step:]


def test_what_is_read_at_the_step_is_what_was_read_then(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    act = driving(lab)
    lab.start()
    seen = lab.run_to(35, act)
    then = [*state.digests(lab.parts), lab.readings()]
    assert then == seen[-1]
    lab.run_to(50, act)
    lab.go_on(35)
    lab.start()  # a digest holds whether the simulation runs or is paused
    assert [*state.digests(lab.parts), lab.readings()] == then
    assert v.simxGetFloatSignal(lab.client, "gain", BLOCKING) == (0, 0.5)


def test_a_stop_after_it_restores_the_state_before_the_first_start(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    before = state.digests(lab.parts)
    lab.start()
    lab.run_to(10, driving(lab))
    lab.go_on(5)
    lab.start()
    lab.run_to(12)
    lab.sim.stop()
    signals = state.QUANTITIES.index("signals")
    assert state.digests(lab.parts)[:signals] == before[:signals]


def test_an_edit_of_the_scene_is_undone_and_done_again(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    copies: list[int] = []

    def act(step: int) -> None:
        if step == 10:
            code, new = v.simxCopyPasteObjects(lab.client, [lab.handle("ball")], BLOCKING)
            assert code == 0
            copies.append(new[0])

    lab.start()
    first = lab.run_to(20, act)
    lab.go_on(5)
    assert copies[0] not in lab.sim.scene.objects
    lab.start()
    assert lab.run_to(20, act) == first[5:]
    assert copies[0] == copies[1], "the copy has the handle that it had"
    lab.go_on(15)
    assert copies[0] in lab.sim.scene.objects
    lab.start()
    assert lab.run_to(20, act) == first[15:]


def test_a_static_object_that_was_moved_stands_where_it_stood(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    post = lab.handle("post")
    lab.start()
    lab.steps(3)
    v.simxSetObjectPosition(lab.client, post, -1, [2, 1, 0.5], BLOCKING)
    lab.steps(3)
    v.simxSetObjectPosition(lab.client, post, -1, [2, 2, 0.5], BLOCKING)
    lab.steps(3)
    for step, y in ((8, 2.0), (5, 1.0), (2, 0.0)):
        lab.go_on(step)
        assert v.simxGetObjectPosition(lab.client, post, -1, BLOCKING)[1] == pytest.approx([2, y, 0.5])
        lab.start()


def test_later_steps_are_gone_and_earlier_ones_stay(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    lab.start()
    lab.steps(20)
    lab.go_on(8)
    assert lab.history.steps == (0, 8)
    with pytest.raises(CommandError, match="step 12 is not kept; kept are steps 0 to 8"):
        lab.go_on(12)
    lab.start()
    lab.steps(2)
    assert lab.history.steps == (0, 10)


def test_it_goes_on_after_the_run_was_stopped_too(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    act = driving(lab)
    lab.start()
    first = lab.run_to(20, act)
    lab.sim.stop()
    lab.go_on(9)
    lab.start()
    signals = state.QUANTITIES.index("signals")
    again = lab.run_to(20, act)
    assert [each[:signals] for each in again] == [each[:signals] for each in first[9:]]
    lab.sim.stop()
    lab.start()
    assert lab.history.steps == (0, 0), "another start is another run"


def test_clients_that_step_go_on_stepping(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    lab.start()
    v.simxStartSimulation(lab.client, BLOCKING)
    for _ in range(6):
        v.simxSynchronousTrigger(lab.client)
    lab.go_on(3)
    lab.start()
    assert lab.loop.service.due.is_waiting_for_trigger
    v.simxSynchronousTrigger(lab.client)
    assert lab.sim.step_count == 4


def test_the_tutorials_scene_goes_on_bit_for_bit(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab("ur5_rg2_kinect")
    joints = lab.joints()

    def act(step: int) -> None:
        if step % 5 == 0:
            for number, joint in enumerate(joints[:6]):
                v.simxSetJointTargetPosition(lab.client, joint, 0.02 * step * (-1) ** number, BLOCKING)

    lab.start()
    first = lab.run_to(16, act)
    gone = lab.go_on(7)
    lab.start()
    again = lab.run_to(16, act)
    assert [each[:-1] for each in again] == [each[:-1] for each in first[7:]]
    assert isinstance(gone.restarted, list)


LUA = """
<mujoco>
  <worldbody>
    <body name="cart" pos="0 0 0.2"><joint name="x" type="slide" axis="1 0 0"/><geom size="0.1"/></body>
  </worldbody>
  <custom>
    <text name="simx:script:cart" data="file={file}"/>
  </custom>
</mujoco>
"""


def test_scripts_start_again_and_the_answer_names_them(
    open_lab: Callable[[str], Lab], tmp_path: Path
) -> None:
    (tmp_path / "count.lua").write_text(
        "function sysCall_init() n = 0; cube = sim.createDummy(0.1) end\n"
        "function sysCall_actuation() n = n + 1; sim.setInt32Signal('n', n) end\n"
    )
    lab = open_lab(LUA.format(file="count.lua"))
    lab.start()
    lab.steps(10)
    objects = set(lab.sim.scene.objects)
    assert lab.parts.signals.integers["n"] == 10
    gone = lab.go_on(6)
    assert lab.parts.signals.integers["n"] == 6, "the signal is that of the step"
    assert set(lab.sim.scene.objects) == objects, "what init made has the handle that it had"
    assert len(gone.restarted) == 1
    assert "count.lua" in gone.restarted[0]
    lab.start()
    lab.steps(1)
    assert lab.parts.signals.integers["n"] == 1, "the script has started again"


def test_a_script_cannot_go_on_from_within_itself(open_lab: Callable[[str], Lab], tmp_path: Path) -> None:
    (tmp_path / "count.lua").write_text(
        "function sysCall_init() end\n"
        "function back()\n"
        "  return sim.callScriptFunction('goOn@simxView', sim.scripttype_addonscript, {2}, {}, {}, '')\n"
        "end\n"
    )
    lab = open_lab(LUA.format(file="count.lua"))
    lab.parts.scripts.add_ons["simxView"] = Feed(lab.loop.service, "lab", (), lab.history)
    lab.start()
    lab.steps(4)
    code, *_ = v.simxCallScriptFunction(lab.client, "cart", 1, "back", (), (), (), b"", BLOCKING)
    assert code == v.simx_return_remote_error_flag
    assert "while a script is being executed" in v.simxGetLastErrors(lab.client, BLOCKING)[1][-1]
    assert lab.sim.step_count == 4


def test_a_state_that_cannot_be_restored_ends_the_run(
    open_lab: Callable[[str], Lab], monkeypatch: pytest.MonkeyPatch
) -> None:
    lab = open_lab(MACHINE)
    before = state.digests(lab.parts)
    lab.start()
    lab.steps(5)

    def fail(*_: object) -> None:
        raise MemoryError("no room")

    monkeypatch.setattr(going_on, "restore", fail)
    with pytest.raises(MemoryError):
        lab.go_on(3)
    assert not lab.sim.is_running
    assert not lab.sim.is_going_back
    assert state.digests(lab.parts) == before


def test_a_server_that_ends_with_its_run_does_not_end_with_a_new_one(
    open_lab: Callable[[str], Lab],
) -> None:
    lab = open_lab(MACHINE)
    lab.loop.service.watchers.add(QuitAfterStop(lab.loop.service.ending, lab.sim))
    lab.start()
    lab.steps(5)
    lab.go_on(3)
    lab.loop.turn()
    assert not lab.loop.service.ending.has_come
    lab.sim.stop()
    lab.loop.turn()
    assert lab.loop.service.ending.has_come


def test_derived_numbers_are_those_of_the_step(open_lab: Callable[[str], Lab]) -> None:
    lab = open_lab(MACHINE)
    lab.start()
    lab.steps(15)
    kept = {
        name: getattr(lab.sim.data, name).copy() for name in ("qfrc_bias", "actuator_force", "xpos", "qvel")
    }
    lab.steps(5)
    lab.go_on(15)
    for name, values in kept.items():
        assert np.array_equal(getattr(lab.sim.data, name), values), name
