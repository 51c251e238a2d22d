"""The gripper's Lua child script alone, run against the four functions of the simulation that it uses."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow

SCENES = Path(__file__).parents[2] / "scenes"


class FakeSim:
    """The four functions the gripper script uses; remembers what the finger motor was told."""

    def __init__(self) -> None:
        self.signals: dict[str, int] = {}
        self.force = 0.0
        self.velocity = 0.0

    def getObjectHandle(self, name: str) -> int:
        assert name == "RG2_openCloseJoint"
        return 57

    def setJointForce(self, handle: int, force: float) -> None:
        assert handle == 57
        self.force = force

    def setJointTargetVelocity(self, handle: int, velocity: float) -> None:
        assert handle == 57
        self.velocity = velocity

    def getIntegerSignal(self, name: str) -> int | None:
        return self.signals.get(name)


@pytest.fixture
def gripper_script() -> tuple[FakeSim, Callable[..., Any]]:
    """(the simulation the script sees, a function that calls one of the script's functions by name)."""
    lupa = pytest.importorskip("lupa")
    lua = lupa.LuaRuntime()
    sim = FakeSim()
    functions = ("getObjectHandle", "setJointForce", "setJointTargetVelocity", "getIntegerSignal")
    lua.globals().sim = lua.table_from({name: getattr(sim, name) for name in functions})
    lua.execute((SCENES / "models" / "rg2.lua").read_text(encoding="utf-8"))
    return sim, lambda name, *args: lua.globals()[name](*args)


def test_gripper_script_opens_at_start_and_answers_like_the_tutorials(
    gripper_script: tuple[FakeSim, Callable[..., Any]],
) -> None:
    sim, call = gripper_script
    call("sysCall_init")
    assert (sim.velocity, sim.force) == (0.05, 20)
    for name, velocity in (("rg2Close", -0.05), ("rg2Open", 0.05)):
        ints, floats, strings, buffer = call(name, [], [], [], "")
        assert (list(ints.values()), list(floats.values()), list(strings.values())) == ([], [velocity], [])
        assert buffer == ""
        assert sim.velocity == velocity


def test_gripper_script_obeys_a_change_of_the_signal_once(
    gripper_script: tuple[FakeSim, Callable[..., Any]],
) -> None:
    sim, call = gripper_script
    call("sysCall_init")
    call("sysCall_actuation")
    assert sim.velocity == 0.05
    sim.signals["RG2_open"] = 0
    call("sysCall_actuation")
    assert sim.velocity == -0.05
    call("rg2Open", [], [], [], "")
    call("sysCall_actuation")
    assert sim.velocity == 0.05, "a standing signal must not undo a later call"
    sim.signals["RG2_open"] = 1
    call("sysCall_actuation")
    sim.signals["RG2_open"] = 0
    call("sysCall_actuation")
    assert sim.velocity == -0.05
