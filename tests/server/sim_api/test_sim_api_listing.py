"""The API lists itself for programs that complete or explain code."""

from __future__ import annotations

from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


def test_names_of_the_api_are_completed(world: ScriptWorld) -> None:
    (found,) = world.lua("return sim.getApiFunc(-1, 'sim.getObjectPos')")
    assert found == ["sim.getObjectPose", "sim.getObjectPosition"]
    assert "simIK" in world.lua("return sim.getApiFunc(-1, 'sim')")[0], "without a dot, namespaces"
    assert world.lua("return sim.getApiFunc(-1, '-sim.handle_all_except_e')") == [
        ["sim.handle_all_except_explicit"]
    ]
    assert world.lua("return sim.getApiFunc(-1, '+sim.handle_all_except_e')") == [[]]
    assert len(world.lua("return sim.getApiFunc(-1, '')")[0]) > 1000


def test_a_name_of_the_api_is_explained(world: ScriptWorld) -> None:
    tip, explanation = world.value("sim.getApiInfo(-1, 'sim.getObject')").split("\n", 1)
    assert tip == "sim.getObject(path, options=nil)"
    assert explanation.startswith("Return the handle of an object")
    assert world.value("sim.getApiInfo(-1, 'sim.handle_all')") == "sim.handle_all = -2"
    assert world.lua("return sim.getApiInfo(-1, 'sim.nix')") == []
