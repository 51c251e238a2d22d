"""V-REP 3's custom UIs for scripts: made, changed, and operated by people."""

from __future__ import annotations

from sim_api_calls import ScriptWorld, world

__all__ = ["world"]


def test_a_script_makes_a_ui_and_reads_what_people_do(world: ScriptWorld) -> None:
    ui, menu = world.lua(
        "return simCreateUI('drive', sim.ui_menu_title | sim.ui_menu_close, {10, 4}, {14, 14})"
    )
    assert menu == [0, 1]
    slider = world.value(
        f"simCreateUIButton({ui}, {{0, 1}}, {{8, 1}}, sim.buttonproperty_slider | sim.buttonproperty_enabled)"
    )
    button = world.value(f"sim.createUIButton({ui}, {{0, 2}}, {{4, 1}}, sim.buttonproperty_enabled)")
    world.lua(f"simSetUIButtonLabel({ui}, {button}, 'go'); simSetUISlider({ui}, {slider}, 333.7)")
    assert world.value(f"simGetUISlider({ui}, {slider})") == 333
    assert world.value(f"sim.getUIButtonSize({ui}, {slider})") == [8, 1]
    people = world.parts.user_interface.custom_uis
    people.click(ui, button)
    people.move_slider(ui, slider, 900)
    assert world.lua(f"return simGetUIEventButton({ui})")[0] == button
    event, (_, position) = world.lua(f"return simGetUIEventButton({ui})")
    assert (event, position) == (slider, 900)
    (shown,) = people.describe()
    assert [element["label"] for element in shown["elements"]] == ["drive", "&&Cross", "", "go"]
    people.click(ui, menu[1])
    assert not people.describe()[0]["visible"]


def test_properties_hide_a_ui_and_show_it_again(world: ScriptWorld) -> None:
    ui, _ = world.lua("return sim.createUI('panel', 0, {4, 4}, {14, 14})")
    people = world.parts.user_interface.custom_uis
    world.lua(
        f"local p = simGetUIProperty({ui}); p = simBoolOr32(p, sim_ui_property_visible);"
        f"simSetUIProperty({ui}, p - sim_ui_property_visible)"
    )
    assert not people.describe()[0]["visible"]
    world.lua(f"sim.setUIProperty({ui}, sim.boolOr32(sim.getUIProperty({ui}), sim.ui_property_visible))")
    assert people.describe()[0]["visible"]
    world.fails(f"sim.setUIProperty({ui}, -1)", "sim_ui_property_ bits")


def test_colours_and_places_are_kept(world: ScriptWorld) -> None:
    ui, _ = world.lua("return sim.createUI('panel', sim.ui_menu_title, {4, 4})")
    world.lua(f"sim.setUIButtonColor({ui}, 0, {{1, 0, 0}}, nil, {{0, 0, 2}})")
    world.lua(f"sim.setUIButtonColor({ui}, 0, nil, {{0, 1, 0}})")
    element = world.parts.user_interface.custom_uis.get(ui).element(0)
    assert element.colors == [(1, 0, 0), (0, 1, 0), (0, 0, 1)]
    world.lua(f"sim.setUIPosition({ui}, {{30, 40}})")
    assert world.value(f"sim.getUIPosition({ui})") == [30, 40]
    assert world.lua(f"return sim.createUIButtonArray({ui}, 0), sim.deleteUIButtonArray({ui}, 0)") == [1, 1]
    world.lua(f"sim.setUIButtonArrayColor({ui}, 0, {{0, 0}}, {{1, 1, 1}})")


def test_what_is_wrong_is_refused_with_the_reason(world: ScriptWorld) -> None:
    assert world.value("simGetUIHandle('none@silentError')") == -1
    world.fails("simGetUIHandle('none')", "no custom UI named 'none'")
    world.fails("sim.createUI('x', 0, {0, 4})", "the size must be two whole numbers from 1")
    ui, _ = world.lua("return sim.createUI('x', 0, {4, 4})")
    world.fails(f"sim.createUIButton({ui}, {{0}}, {{1, 1}}, 0)", "the position must be two whole numbers")
    world.fails(f"sim.createUIButton({ui}, {{0, 0}}, {{1, 1}}, 5)", "is no property of a button")
    world.fails(f"sim.setUIButtonColor({ui}, 0, {{1}})", "a colour must be three numbers")
    world.fails(
        f"for i = 1, 2000 do sim.createUIButton({ui}, {{0, 0}}, {{1, 1}}, 0) end", "has 1000 buttons already"
    )
