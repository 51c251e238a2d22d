"""Plug-ins that scripts look for, and programs and ports that they may not use."""

from __future__ import annotations

import pytest
from sim_api_calls import ScriptWorld, world

import simx_server

__all__ = ["world"]

OLD = ["IK", "OMPL", "RemoteApi", "Vision", "CustomUI"]
NEW = ["simIK", "simOMPL", "simRemoteApi", "simVision", "simUI"]


@pytest.mark.parametrize(("function", "names"), [("getModuleName", OLD), ("getPluginName", NEW)])
def test_a_loop_over_plug_ins_ends_with_nil(world: ScriptWorld, function: str, names: list[str]) -> None:
    loop = f"local found, i = {{}}, 0 repeat local name = sim.{function}(i) i = i + 1 found[i] = name until not name"
    assert world.lua(f"{loop} return found") == [names]
    assert world.lua("return (sim.getModuleName(0)), (sim.getPluginName(-1))") == ["IK", None]


def test_plug_ins_are_loaded_if_the_server_has_them(world: ScriptWorld) -> None:
    assert world.value("sim.getLoadedPlugins()") == NEW
    assert world.lua("return sim.isPluginLoaded('simIK'), sim.isPluginLoaded('IK')") == [True, True]
    assert world.value("sim.isPluginLoaded('simOctomap')") is False
    assert world.value("sim.loadModule('folder/v_repExtVision.dll', 'Vision')") == 3
    assert world.value("sim.loadPlugin('simVision')") == 3
    assert world.value("sim.loadPlugin('simOctomap')") == -3
    assert world.parts.status_bar.messages[-1].startswith("plug-in 'simOctomap' cannot be loaded")
    assert world.lua("return sim.unloadModule(3), sim.unloadPlugin(3)") == [0, 0]


def test_a_plug_in_has_the_servers_version(world: ScriptWorld) -> None:
    version = simx_server.__version__
    assert world.lua(
        "return sim.getModuleInfo('IK', sim.moduleinfo_extversionstr), sim.getPluginInfo('simIK', 0)"
    ) == [version, version]
    major, minor, patch = (int(part) for part in version.split(".")[:3])
    number = major * 10000 + minor * 100 + patch
    assert world.lua("local _, version = sim.getModuleName(0) return version, sim.getModuleInfo(0, 2)") == [
        number,
        number,
    ]
    assert world.value("sim.setModuleInfo('IK', sim.moduleinfo_verbosity, 300)") == 1
    assert world.value("sim.sendModuleMessage(0, {}, '')") == -1
    world.goes_on("sim.getModuleInfo('ROS', 0)", "no plug-in 'ROS'; plug-ins here are IK, OMPL")
    world.goes_on("sim.getModuleInfo('IK', 9)", "those are 0 to 4")


def test_what_a_script_sets_about_a_plugin_is_returned_until_another_scene(world: ScriptWorld) -> None:
    ask = "sim.getPluginInfo('simVision', sim.plugininfo_{})"
    world.lua("sim.setPluginInfo('simVision', sim.plugininfo_builddatestr, 'today')")
    world.lua("sim.setPluginInfo('Vision', sim.plugininfo_extversionint, 7)")
    assert world.value(ask.format("builddatestr")) == "today"
    assert world.value(ask.format("extversionint")) == 7
    world.fails(
        "sim.setPluginInfo('simVision', sim.plugininfo_verbosity, 'x')", "3 on a plug-in is of the type int"
    )
    world.fails("sim.setPluginInfo('simVision', 9, 1)", "those are 0 to 4")
    world.call("simxStopSimulation")
    world.parts.plugin_infos.scene_changed()
    assert world.parts.plugin_infos.get("simVision", 1) is None


def test_a_plugin_says_no_more_than_a_script_allows(
    world: ScriptWorld, caplog: pytest.LogCaptureFixture
) -> None:
    create = "simUI.create('<ui><{}/></ui>')"
    note = "these widgets are kept and not shown: {}"
    caplog.set_level("INFO")
    world.lua("sim.setPluginInfo('simUI', sim.plugininfo_statusbarverbosity, sim.verbosity_errors)")
    world.lua(create.format("datetime"))
    assert not any(note.format("datetime") in line for line in world.parts.status_bar.messages)
    assert note.format("datetime") in caplog.text
    world.lua("sim.setPluginInfo('simUI', sim.plugininfo_verbosity, sim.verbosity_none)")
    world.lua(create.format("webview"))
    assert "webview" not in caplog.text
    world.lua("sim.setPluginInfo('simUI', sim.plugininfo_statusbarverbosity, sim.verbosity_useglobal)")
    world.lua(create.format("dataflow"))
    assert note.format("dataflow") in world.parts.status_bar.messages[-1]
