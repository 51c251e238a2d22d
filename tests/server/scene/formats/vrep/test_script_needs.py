"""The needs of a script's text: found in the text, without running it."""

from __future__ import annotations

import pytest

from simx_server.scene.formats.vrep.script_needs import needs_of


@pytest.mark.parametrize(
    ("text", "members"),
    [
        ("h = sim.getObject('/arm')", {"sim.getObject"}),
        ("sim.setJointMode(h, sim.jointmode_dynamic)", {"sim.setJointMode", "sim.jointmode_dynamic"}),
        ("simGetObjectHandle('arm')", {"sim.getObjectHandle"}),
        ("simSetJointMode(h, sim_jointmode_force)", {"sim.setJointMode", "sim.jointmode_force"}),
        ("simRMLPos(1) x = simrml_no_sync", {"sim.rmlPos", "sim.rml_no_sync"}),
        ("simExtRemoteApiStart(19999)", {"sim.extRemoteApiStart"}),
        ("local f = sim.getJointPosition f(1)", {"sim.getJointPosition"}),
        ("simUI.create [[<ui/>]]", {"simUI.create"}),
        ("simx.start('127.0.0.1', 19997)", {"simx.start"}),
        ("simSwitchThread{}", {"sim.switchThread"}),
        ("f = io.open('a') loadfile('b')() os.time() x = io", {"io.open"}),
        ("if sim_call_type == sim.syscb_init then end", {"sim.syscb_init"}),
    ],
)
def test_members_of_namespaces_are_found(text: str, members: set[str]) -> None:
    assert needs_of(text).members == members


@pytest.mark.parametrize(
    "text",
    [
        "-- sim.getObject('/arm')",
        "--[[ sim.getObject('/arm')\n sim.wait(1) ]]",
        "--[==[ ]] sim.wait(1) ]==]",
        'x = "sim.getObject"',
        "x = [[ sim.getObject() ]]",
        "x = 'it is \\' sim.wait(1)'",
        "model.sim.getObject()",
        "simulate(1)",
        "similar = simple.of(2)",
    ],
)
def test_comments_texts_and_other_names_are_no_needs(text: str) -> None:
    assert not needs_of(text).members


@pytest.mark.parametrize(
    "text",
    [
        "function simMine() end simMine()",
        "simMine = function() end simMine()",
        "function sim.mine() end sim.mine()",
        "sim.mine = 3 x = sim.mine",
        "local simHelper = {} simHelper.run()",
        "local function simMine() end simMine()",
    ],
)
def test_what_the_script_defines_is_no_need(text: str) -> None:
    assert not needs_of(text).members


def test_a_comparison_defines_nothing() -> None:
    assert needs_of("if sim.mine == 3 then end").members == {"sim.mine"}


def test_a_variable_can_stand_for_a_namespace() -> None:
    text = "local s = require('sim') local k = require 'simIK-2' s.wait(1) k.createGroup()"
    assert needs_of(text).members == {"sim.wait", "simIK.createGroup"}
    assert needs_of("s = sim s.wait(1)").members == {"sim.wait"}


def test_required_modules_are_found_and_namespaces_are_none() -> None:
    text = "sim = require('sim-2') g = require('models.graph_customization-2') sim.include('/lua/path.lua')"
    assert needs_of(text).modules == {"models.graph_customization-2", "path"}


def test_python_has_its_own_comments_and_texts() -> None:
    text = '''#python
def sysCall_init():
    sim = require('sim')
    """ sim.wait(1) """
    self.arm = sim.getObject('/arm')  # sim.step()
    self.ik = require("simIK")
    self.ik.createEnvironment()
'''
    assert needs_of(text, "python").members == {"sim.getObject", "simIK.createEnvironment"}


@pytest.mark.parametrize(
    "text", ["--[[ sim.x", "x = [==[ sim.x", "x = 'sim.x", '"' * 20_000, "\\" * 20_000, "sim."]
)
def test_unfinished_text_is_read_to_its_end(text: str) -> None:
    assert not needs_of(text).members


def test_python_needs_processes_where_it_starts_one() -> None:
    text = "subprocess.run(['ls'])\nos.system('ls')\nos.path.join('a', 'b')\nos.getcwd()"
    assert needs_of(text, "python").members == {"subprocess.run", "os.system"}
    assert not needs_of(f"subprocess = Mine()\nos = Mine()\n{text}", "python").members


def test_missing_names_what_is_not_offered() -> None:
    needs = needs_of("sim.wait(1) simUI.create('') sim.there() require('a') require('b')")
    offered = {"sim": frozenset({"there"})}
    assert needs.missing(offered, frozenset({"b"})) == ["sim.wait", "simUI.create", "require 'a'"]
