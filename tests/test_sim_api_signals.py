"""Signals between scripts and clients, by all their names."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


@pytest.mark.parametrize(
    ("kind", "value", "read"),
    [
        ("Integer", "7", 7),
        ("Int32", "-7", -7),
        ("Float", "0.5", 0.5),
        ("Double", "0.1", 0.1),
        ("String", "'a\\0b'", "a\0b"),
        ("Buffer", "'x'", "x"),
    ],
)
def test_a_signal_is_set_read_and_cleared(world: ScriptWorld, kind: str, value: str, read: object) -> None:
    assert world.value(f"sim.get{kind}Signal('s')") is None
    world.lua(f"sim.set{kind}Signal('s', {value}); sim.set{kind}Signal('t', {value})")
    assert world.value(f"sim.get{kind}Signal('s')") == read
    world.lua(f"sim.clear{kind}Signal('s')")
    assert world.value(f"sim.get{kind}Signal('s')") is None
    assert world.value(f"sim.get{kind}Signal('t')") == read
    world.lua(f"sim.clear{kind}Signal('')")
    assert world.value(f"sim.get{kind}Signal('t')") is None


def test_clients_and_scripts_see_the_same_signals(world: ScriptWorld) -> None:
    world.call("simxSetIntegerSignal", "from_client", 3)
    assert world.value("sim.getInt32Signal('from_client')") == 3
    world.lua("sim.setStringSignal('from_script', 'hi')")
    assert world.call("simxGetStringSignal", "from_script") == b"hi"
    world.call("simxStopSimulation")
    assert "from_script" not in world.sim.signals.strings, "it goes with its script"
    assert world.sim.signals.get_integer("from_client") == 3


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
