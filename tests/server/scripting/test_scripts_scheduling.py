"""Calls that scripts leave for later, messages between scripts, their order, and what switches them off."""

from __future__ import annotations

import pytest
from scripted_world import evaluate, said, scripted

pytest.importorskip("lupa")

TELL = """
function sysCall_init() print('%s init') end
function sysCall_actuation() print('%s actuation') end
function sysCall_msg(message, sender) print('%s heard', message.id, sender) end
function later(...) print('%s later', sim.getSimulationTime(), ...) end
"""


def tell(name: str) -> str:
    return TELL.replace("%s", name)


def test_a_call_is_made_when_its_simulated_time_has_come() -> None:
    world = scripted({"lua:base": tell("base")})
    world.run(0)
    evaluate(world, "sim.scheduleExecution(later, {1, 'x'}, 0.1, true)")
    evaluate(world, "sim.scheduleExecution('later', {2}, 0.1, true)")
    said(world)
    world.run(4)
    assert [line for line in said(world) if "later" in line] == [
        "base later, 0.1, 1, x",
        "base later, 0.1, 2",
    ]


def test_a_call_of_the_wall_clock_is_due_at_once_if_its_time_is_past() -> None:
    world = scripted({"lua:customization:base": tell("base")})
    said(world)
    evaluate(world, "sim.scheduleExecution(later, {}, sim.getSystemTime() - 1)", kind=6)
    evaluate(world, "sim.scheduleExecution(later, {}, sim.getSystemTime() + 1000)", kind=6)
    world.parts.idle()
    world.parts.idle()
    assert said(world) == ["base later, 0.0"]


def test_a_cancelled_call_is_not_made() -> None:
    world = scripted({"lua:base": tell("base")})
    world.run(0)
    (number,) = evaluate(world, "return sim.scheduleExecution(later, {}, 0, true)")
    assert evaluate(world, f"return sim.cancelScheduledExecution({number})") == [True]
    assert evaluate(world, f"return sim.cancelScheduledExecution({number})") == [False]
    said(world)
    world.run(1)
    assert said(world) == ["base actuation"]


def test_scheduled_calls_end_with_their_script() -> None:
    world = scripted({"lua:base": tell("base")})
    world.run(0)
    evaluate(world, "sim.scheduleExecution(later, {}, 0, true)")
    world.sim.stop()
    said(world)
    world.run(1)
    assert said(world) == ["base init", "base actuation"]


def test_a_message_reaches_all_other_scripts() -> None:
    world = scripted(
        {"lua:base": tell("base"), "lua:plain": tell("plain"), "lua:customization:left": tell("left")}
    )
    world.run(0)
    (sender,) = evaluate(world, "return sim.getScriptHandle()")
    said(world)
    evaluate(world, "sim.broadcastMsg({id = 'hello'})")
    assert sorted(said(world)) == [f"left heard, hello, {sender}", f"plain heard, hello, {sender}"]
    evaluate(world, "sim.broadcastMessage({id = 'again'})")
    assert len(said(world)) == 2


def test_the_order_of_a_script_decides_among_siblings() -> None:
    names = ("base", "left", "leaf", "right", "plain")
    world = scripted({f"lua:{name}": tell(name) for name in names})
    world.run(0)
    for name, order in (("right", "first"), ("leaf", "last"), ("base", "last")):
        attribute = f"sim.scriptattribute_executionorder, sim.scriptexecorder_{order}"
        evaluate(world, f"sim.setScriptAttribute(sim.handle_self, {attribute})", on=name)
    said(world)
    world.run(1)
    order = ("plain", "right", "leaf", "left", "base")
    assert said(world) == [f"{name} actuation" for name in order]


@pytest.mark.parametrize(
    ("traversals", "order"),
    [
        ({"base": "forward"}, ("base", "leaf", "left", "right", "plain")),
        ({"base": "forward", "left": "parent"}, ("base", "left", "leaf", "right", "plain")),
        ({"left": "forward", "leaf": "parent"}, ("left", "leaf", "right", "base", "plain")),
        ({"left": "parent"}, ("leaf", "left", "right", "base", "plain")),
    ],
)
def test_a_script_with_forward_traversal_is_called_before_those_below_it(
    traversals: dict[str, str], order: tuple[str, ...]
) -> None:
    notes = {f"script:{name}": f"traversal={traversal}" for name, traversal in traversals.items()}
    world = scripted(
        {f"lua:{name}": tell(name) for name in ("base", "left", "leaf", "right", "plain")} | notes
    )
    world.run(0)
    said(world)
    world.run(1)
    assert said(world) == [f"{name} actuation" for name in order]


def test_a_customization_script_may_sleep_during_a_run() -> None:
    world = scripted({"lua:customization:base": tell("base")})
    attribute = "sim.customizationscriptattribute_activeduringsimulation"
    evaluate(world, f"sim.setScriptAttribute(sim.handle_self, {attribute}, false)", kind=6)
    assert evaluate(world, f"return sim.getScriptAttribute(sim.handle_self, {attribute})", kind=6) == [False]
    said(world)
    world.run(2)
    assert said(world) == []
    evaluate(world, f"sim.setScriptAttribute(sim.handle_self, {attribute}, true)", kind=6)
    world.run(1)
    assert said(world) == ["base actuation"]


def test_a_script_that_was_disabled_before_the_run_starts_when_it_is_enabled() -> None:
    world = scripted({"lua:base": tell("base"), "lua:customization:plain": tell("plain")})
    find = "sim.getScriptAssociatedWithObject(sim.getObject('/base'))"
    enable = f"sim.setScriptAttribute({find}, sim.childscriptattribute_enabled, %s)"
    evaluate(world, enable % "false", on="plain", kind=6)
    world.run(1)
    assert [line for line in said(world) if line.startswith("base")] == []
    evaluate(world, enable % "true", on="plain", kind=6)
    world.run(1)
    assert [line for line in said(world) if line.startswith("base")] == ["base init", "base actuation"]


def test_a_main_script_passes_values_on_and_calls_single_scripts() -> None:
    child = "function sysCall_actuation(...) print('child', ...) end"
    main = """
    function sysCall_actuation()
        print(sim.handleChildScripts(sim.syscb_actuation, 7, 'x'), sim.handleSimulationScripts(sim.syscb_actuation, 8))
        print(sim.handleChildScript(sim.getObject('/base'), 9), sim.handleChildScript(sim.getObject('/plain')))
        print(sim.delegateChildScriptExecution(), sim.handleEmbeddedScripts(1), sim.handleMainScript())
        print(sim.handleJoint(-2, 0.05), sim.handleVarious(), sim.enableWorkThreads(-1), sim.waitForWorkThreads())
        sim.handleExtCalls()
        print(sim.resetMilling(-2))
    end
    """
    world = scripted({"lua:base": child, "lua:main": main})
    world.run(1)
    assert said(world) == [
        "child, 7, x",
        "child, 8",
        "1, 1",
        "child, 9",
        "1, 0",
        "0, 0, 0",
        "1, 1, 1, 1",
        "0",
    ]
