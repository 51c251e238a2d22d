"""``simx-check`` lists the differences that matter for the calls that a program makes, and only those."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked_programs import check, page_of, write

from simx_client.checking.idioms import COMMON_PARAMETERS, HABITS
from simx_client.protocol.differences import DIFFERENCES, NEVER
from simx_server.handlers.objects.parameter_tables import entries_of
from simx_server.scene.objects import ObjectKind

ROOT = Path(__file__).parents[3]

BEGIN = """
import vrep, time
vrep.simxFinish(-1)
c = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)
B = vrep.simx_opmode_blocking
vrep.simxStartSimulation(c, B)
_, h = vrep.simxGetObjectHandle(c, 'it', B)
"""
END = "vrep.simxStopSimulation(c, B)\nvrep.simxFinish(c)\n"

LOOP = "while True:\n  vrep.simxGetObjectPosition(c, h, -1, B)\n"
SET = "while True:\n  vrep.simxSetObjectPosition(c, h, -1, (0, 0, 1), vrep.simx_opmode_oneshot)\n"
TRIGGER = "vrep.simxSynchronous(c, 1)\nvrep.simxSynchronousTrigger(c)\n"
STREAM = "vrep.simxGetObjectPosition(c, h, -1, {})\n"


def numbers_of(folder: Path, text: str) -> set[int]:
    write(folder, {"script.py": BEGIN + text + END})
    _, record = check(folder / "script.py")
    return {each["number"] for each in record["differences"]}


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("", set[int]()),
        (LOOP, {5}),
        (LOOP + "  time.sleep(0.05)\n", set()),
        (LOOP + TRIGGER + "vrep.simxGetPingTime(c)\n", set()),
        (SET, {47, 48}),
        (SET + "  time.sleep(0.05)\n", set()),
        (TRIGGER, {2}),
        (TRIGGER + "vrep.simxGetPingTime(c)\n", set()),
        (TRIGGER + "d = vrep.simxStart('127.0.0.1', 19998, True, True, 5000, 5)\n", {2, 53}),
        ("vrep.simxStart('127.0.0.1', 19999, True, True, 5000, 5)\n", {7}),
        ("vrep.simxStart('192.168.0.3', 19997, True, True, 5000, 5)\n", {11}),
        ("vrep.simxStart('127.0.0.1', -19997, True, True, 5000, 5)\n", {30}),
        ("vrep.simxSetJointTargetVelocity(c, h, 1, B)\n", {9}),
        ("vrep.simxGetVisionSensorImage(c, h, 0, B)\n", set()),
        ("vrep.simxGetVisionSensorImage(c, h, 1, B)\n", {57}),
        ("vrep.simxSetFloatSignal(c, 'x', 1, B)\n", {14}),
        ("vrep.simxGetObjectVelocity(c, h, B)\n", {37}),
        ("vrep.simxLoadModel(c, 'x.ttm', 0, B)\n", {10, 33, 34, 45}),
        ("vrep.simxSetObjectParent(c, h, -1, True, B)\n", set()),
        ("vrep.simxSetObjectParent(c, h, -1, False, B)\n", {43}),
        ("vrep.simxSetFloatingParameter(c, vrep.sim_floatparam_simulation_time_step, 0.01, B)\n", set()),
        ("vrep.simxGetFloatingParameter(c, 0, B)\n", {61, 63}),
        ("vrep.simxGetObjectFloatParameter(c, h, 2012, B)\n", set()),
        ("vrep.simxGetObjectFloatParameter(c, h, 3001, B)\n", {62}),
        ("vrep.simxSetBooleanParameter(c, 10, False, B)\n", {56, 60}),
        ("vrep.simxSetObjectIntParameter(c, h, 1017, 2, B)\n", {62, 70}),
        ("vrep.simxGetObjectGroupData(c, 1, 0, B)\n", set()),
        ("vrep.simxGetObjectGroupData(c, 1, 11, B)\n", {12}),
        ("vrep.simxPauseCommunication(c, True)\nvrep.simxPauseCommunication(c, False)\n" + STREAM.format("B"), set()),
        ("vrep.simxPauseCommunication(c, True)\n" + STREAM.format("B") + "vrep.simxPauseCommunication(c, 0)\n", {16}),
        ("vrep.simxGetObjectSelection(c, vrep.simx_opmode_discontinue)\n", {23}),
    ],
)  # fmt: skip
def test_differences_that_matter_are_listed(tmp_path: Path, text: str, numbers: set[int]) -> None:
    assert numbers_of(tmp_path, text) == numbers


def test_script_calls_that_mix_modes_are_told(tmp_path: Path) -> None:
    call = "vrep.simxCallScriptFunction(c, 'a', 1, 'go', [], [], [], '', {})\n"
    assert numbers_of(tmp_path, call.format("B")) == set()
    assert numbers_of(tmp_path, call.format("B") + call.format("vrep.simx_opmode_oneshot")) == {15}


def test_usual_scripts_have_few_and_the_page_tells_them_in_full(tmp_path: Path) -> None:
    for script in sorted((ROOT / "tests/old_programs/programs").glob("*.py")):
        assert len(check(script)[1]["differences"]) <= 5, script.name
    page = page_of(ROOT / "tests/old_programs/programs/pendulum_torque.py", "--differences")
    assert "MuJoCo does the physics." in page
    assert "-1 comes with a reason" not in page


def test_each_difference_names_a_habit_that_is_recognised() -> None:
    assert {each.when for each in DIFFERENCES} - {"", NEVER} == set(HABITS)
    assert all(each.commands for each in DIFFERENCES if not each.when), (
        "without functions it could never be seen"
    )


def test_parameters_that_are_called_common_are_all_there() -> None:
    there = {str(number) for kind in ObjectKind for number in entries_of(kind)}
    assert there >= COMMON_PARAMETERS
