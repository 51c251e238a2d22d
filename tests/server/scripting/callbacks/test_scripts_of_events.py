"""``sysCall_event``: changes of properties, and events of scripts."""

from __future__ import annotations

import pytest
from handler_calls import World
from scripted_world import evaluate, said, scripted

from simx_server.sim_api.scripts import events
from simx_server.sim_api.values.cbor import decode

pytest.importorskip("lupa")

LISTENER = """
cbor = require 'org.conman.cbor'
function sysCall_event(events)
    for _, event in ipairs(cbor.decode(events)) do
        local names = {}
        for name in pairs(event.data) do names[#names + 1] = name end
        table.sort(names)
        print(event.event, event.handle, table.concat(names, ' '))
    end
end
"""


def listening(extra: str = "") -> World:
    world = scripted({"lua:base": LISTENER, "lua:plain": extra or "x = 1"})
    world.run(0)
    return world


def test_only_changes_of_the_chosen_properties_arrive() -> None:
    world = listening()
    leaf = world.handle("leaf")
    evaluate(world, f"return sim.setEventFilters({{[{leaf}] = {{'pose', 'alias'}}}})")
    world.parts.step()
    assert said(world) == []
    world.call("simxSetObjectPosition", leaf, -1, [0.0, 0.0, 1.0])
    world.parts.step()
    assert said(world) == [f"objectChanged, {leaf}, pose"]
    evaluate(world, f"return sim.setObjectAlias({leaf}, 'other')")
    world.parts.step()
    assert said(world) == [f"objectChanged, {leaf}, alias"]


def test_without_filters_all_changes_arrive() -> None:
    world = listening()
    leaf = world.handle("leaf")
    world.parts.step()
    said(world)
    world.call("simxSetObjectPosition", leaf, -1, [0.0, 0.0, 2.0])
    world.parts.step()
    lines = said(world)
    (line,) = [line for line in lines if line.startswith(f"objectChanged, {leaf},")]
    assert {"absPose", "pose", "position"} <= set(line.split(", ")[2].split())
    assert any(line.startswith("sceneChanged,") and "simulationTime" in line for line in lines)
    evaluate(world, f"return sim.setEventFilters({{[{leaf}] = {{'alias'}}}})")
    world.call("simxSetObjectPosition", leaf, -1, [0.0, 0.0, 3.0])
    world.parts.step()
    assert said(world) == []
    evaluate(world, "return sim.setEventFilters({})")
    world.parts.step()
    said(world)
    world.call("simxSetObjectPosition", leaf, -1, [0.0, 0.0, 4.0])
    world.parts.step()
    assert any(f"objectChanged, {leaf}" in line for line in said(world))


def test_a_filter_for_all_objects_reports_each_that_changes() -> None:
    world = listening()
    left, right = world.handle("left"), world.handle("right")
    evaluate(world, "return sim.setEventFilters({[sim.handle_sceneobject] = {'layer'}})")
    for handle in (left, right):
        evaluate(world, f"return sim.setIntProperty({handle}, 'layer', 4)")
    world.parts.step()
    assert said(world) == [f"objectChanged, {left}, layer", f"objectChanged, {right}, layer"]


def test_events_of_a_script_reach_all_that_listen() -> None:
    world = listening()
    evaluate(world, f"return sim.setEventFilters({{[{world.handle('leaf')}] = {{'alias'}}}})")
    for options in (0, 0, 1, 1):
        evaluate(world, f"return sim.pushUserEvent('mine', -1, -1, {{a = 1, b = 2}}, {options})", on="plain")
    world.parts.step()
    assert said(world) == ["mine, nil, a b"] * 3
    world.parts.step()
    assert said(world) == []


def test_the_genesis_events_have_all_objects() -> None:
    world = listening()
    (data,) = evaluate(world, "return sim.getGenesisEvents()")
    found = decode(data)
    added = [event for event in found if event["event"] == b"objectAdded"]
    assert [event["handle"] for event in added] == list(world.sim.scene.objects)
    assert all({"alias", "pose", "objectType"} <= event["data"].keys() for event in added)
    assert len({event["seq"] for event in found}) == len(found)


def test_wrong_filters_are_an_error() -> None:
    world = listening("function try() return pcall(sim.setEventFilters, {[1] = 'pose'}) end")
    assert evaluate(world, "return try()", on="plain")[0] is False


def test_a_watch_that_grows_too_large_ends_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    world = listening()
    evaluate(world, "return sim.setEventFilters({[sim.handle_sceneobject] = {'pose'}})")
    monkeypatch.setattr(events, "_MOST_VALUES", len(world.sim.scene.objects))
    evaluate(world, "return sim.createDummy(0.1)")
    world.parts.step()
    (line,) = said(world)
    assert "the script gets no more changes" in line
    world.parts.step()
    assert said(world) == []
