"""Old custom UIs of a V-REP file in the scene that it becomes."""

from __future__ import annotations

import math

from handler_calls import World

import simx_client as v
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.objects import Button, Dummy, OldUI, VrepFile

SLIDER = v.sim_buttonproperty_slider | v.sim_buttonproperty_enabled


def world_with(*uis: OldUI) -> World:
    file = VrepFile(name="test.ttt", serialization=21, program=(3, 4, 0), uis=list(uis))
    file.objects[3] = Dummy(handle=3, name="mark")
    spec, _ = convert(file)
    world = World()
    world.sim.use(*build(spec, None))
    return world


def test_buttons_keep_their_kind_place_labels_and_colours() -> None:
    title = Button(handle=0, position=(0, 0), size=(9, 1), attributes=v.sim_buttonproperty_label, label="Arm")
    slider = Button(handle=7, position=(2, 1), size=(4, 1), attributes=SLIDER, slider=400)
    slider.colors = ((1.0, 0.5, -1.0), (math.nan, 0.0, 0.0), (0.0, 0.0, 0.0))
    world = world_with(
        OldUI(handle=2, name="panel", object=3, size=(10, 4), attributes=7, buttons=[title, slider])
    )
    ui = world.call("simxGetUIHandle", "panel")
    (shown,) = world.parts.user_interface.custom_uis
    assert (shown.title, shown.size, shown.properties) == ("Arm", [10, 4], 7)
    assert world.parts.user_interface.old_uis.owner(ui) == world.handle("mark")
    assert world.call("simxGetUISlider", ui, 7) == 400
    assert shown.widgets[7].cells == [2, 1, 4, 1]
    assert shown.widgets[7].colors == [(1.0, 0.5, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)]


def test_what_a_file_cannot_mean_is_left_out_and_the_rest_stays() -> None:
    good = Button(handle=1, position=(0, 0), size=(1, 1), attributes=SLIDER, slider=9999)
    bad = Button(handle=2, position=(0, 0), size=(1, 1), attributes=-1)
    same = OldUI(handle=2, name="", object=77, attributes=-1, buttons=[good, good, bad])
    world = world_with(same, OldUI(handle=3, name=""))
    uis = world.parts.user_interface.custom_uis
    assert [ui.name for ui in uis] == ["UI", "UI#0"]
    assert world.call("simxGetUISlider", world.call("simxGetUIHandle", "UI"), 1) == 1000
    assert len(uis.get(world.call("simxGetUIHandle", "UI")).widgets) == 1
