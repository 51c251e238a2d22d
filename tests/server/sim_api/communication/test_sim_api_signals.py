"""Signals between scripts and clients, by all their names."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


KINDS = [
    ("sim.setIntegerSignal(%s)", "sim.getIntegerSignal(%s)", "sim.clearIntegerSignal(%s)", "7", 7),
    ("sim.setInt32Signal(%s)", "sim.getInt32Signal(%s)", "sim.clearInt32Signal(%s)", "-7", -7),
    ("sim.setFloatSignal(%s)", "sim.getFloatSignal(%s)", "sim.clearFloatSignal(%s)", "0.5", 0.5),
    ("sim.setDoubleSignal(%s)", "sim.getDoubleSignal(%s)", "sim.clearDoubleSignal(%s)", "0.1", 0.1),
    ("sim.setStringSignal(%s)", "sim.getStringSignal(%s)", "sim.clearStringSignal(%s)", "'a\\0b'", "a\0b"),
    ("sim.setBufferSignal(%s)", "sim.getBufferSignal(%s)", "sim.clearBufferSignal(%s)", "'x'", "x"),
]


@pytest.mark.parametrize(("put", "get", "clear", "value", "read"), KINDS)
def test_a_signal_is_set_read_and_cleared(
    world: ScriptWorld, put: str, get: str, clear: str, value: str, read: object
) -> None:
    assert world.value(get % "'s'") is None
    world.lua(put % f"'s', {value}")
    world.lua(put % f"'t', {value}")
    assert world.value(get % "'s'") == read
    world.lua(clear % "'s'")
    assert world.value(get % "'s'") is None
    assert world.value(get % "'t'") == read
    world.lua(clear % "''")
    assert world.value(get % "'t'") is None


def test_clients_and_scripts_see_the_same_signals(world: ScriptWorld) -> None:
    world.call("simxSetIntegerSignal", "from_client", 3)
    assert world.value("sim.getInt32Signal('from_client')") == 3
    world.lua("sim.setStringSignal('from_script', 'hi')")
    assert world.call("simxGetStringSignal", "from_script") == b"hi"
    world.call("simxStopSimulation")
    assert "from_script" not in world.parts.signals.strings, "it goes with its script"
    assert world.parts.signals.get_integer("from_client") == 3


def test_signals_are_listed(world: ScriptWorld) -> None:
    world.lua("sim.setInt32Signal('a', 1); sim.setInt32Signal('b', 1); sim.setFloatSignal('c', 1)")
    assert world.lua("return sim.getSignalName(0, 0), sim.getSignalName(1, 0), sim.getSignalName(0, 1)") == [
        "a",
        "b",
        "c",
    ]
    assert world.value("sim.getSignalName(2, 0)") is None
    assert world.value("sim.getSignalName(0, 2)") is None
    world.fails("sim.getSignalName(0, 9)", "a kind of signal is 0")


def test_what_sets_or_clears_gives_1_as_in_vrep_3(world: ScriptWorld) -> None:
    for call in (
        "sim.setIntegerSignal('i', 1)",
        "sim.setFloatSignal('f', 1)",
        "sim.setStringSignal('s', 'x')",
        "sim.clearIntegerSignal('i')",
        "sim.clearFloatSignal('f')",
        "sim.clearStringSignal('s')",
        "sim.setObjectPosition(sim.getObject('/wall'), -1, {0, 0, 1})",
        "sim.setObjectOrientation(sim.getObject('/wall'), -1, {0, 0, 0})",
        "sim.setObjectQuaternion(sim.getObject('/wall'), -1, {0, 0, 0, 1})",
        "sim.setObjectMatrix(sim.getObject('/wall'), -1, sim.buildIdentityMatrix())",
        "sim.setObjectParent(sim.getObject('/ray'), sim.getObject('/robot'), true)",
        "sim.setBoolParameter(sim.boolparam_browser_visible, false)",
        "sim.setObjectInt32Param(sim.getObject('/wall'), sim.shapeintparam_respondable, 1)",
    ):
        assert world.lua(f"return {call}") == [1], call
