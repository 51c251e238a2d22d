"""The custom UIs that a scene holds as V-REP 3 saved them: they come with models, and go with their objects."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest
from handler_calls import World

import simx_client as v
from simx_server.scene.formats.annotations import SceneError

pytestmark = pytest.mark.slow

SLIDER = v.sim_buttonproperty_slider | v.sim_buttonproperty_enabled
BUTTON = v.sim_buttonproperty_button | v.sim_buttonproperty_enabled

PANEL: dict[str, Any] = {
    "title": "Panel",
    "properties": v.sim_ui_property_visible | v.sim_ui_property_visibleduringsimulationonly,
    "size": [10, 3],
    "element": [
        {"id": 1, "property": SLIDER, "place": [0, 1, 8, 1], "position": 250},
        {
            "id": 2,
            "property": BUTTON,
            "place": [8, 1, 2, 1],
            "label": "go",
            "colors": [[1, 0, 0], None, None],
        },
    ],
}


def text(name: str, **more: Any) -> str:
    return f'<text name="simx:old_ui:{name}" data={quoteattr(json.dumps({**PANEL, **more}))}/>'


def scene(*texts: str) -> str:
    return (
        "<mujoco><worldbody><body name='robot'><freejoint/><geom size='0.1'/></body></worldbody>"
        f"<custom>{''.join(texts)}<text name='simx:model:robot' data='base=yes'/></custom></mujoco>"
    )


@pytest.fixture
def world() -> World:
    return World(scene(text("panel", object="robot"), text("free")))


def names(world: World) -> list[str]:
    return [ui.name for ui in world.parts.user_interface.custom_uis]


def test_a_scene_brings_its_uis(world: World) -> None:
    ui = world.call("simxGetUIHandle", "panel")
    assert world.call("simxGetUISlider", ui, 1) == 250
    assert world.call("simxGetUIButtonProperty", ui, 2) == BUTTON
    shown = world.parts.user_interface.custom_uis.describe()[0]
    assert shown["title"] == "Panel"
    assert shown["elements"][1]["colors"] == [(1.0, 0.0, 0.0), None, None]
    assert world.parts.user_interface.old_uis.owner(ui) == world.handle("robot")


def test_a_ui_for_simulations_only_cannot_be_used_while_stopped(world: World) -> None:
    people = world.parts.user_interface.custom_uis
    ui = world.call("simxGetUIHandle", "panel")
    assert not people.describe()[0]["visible"]
    with pytest.raises(Exception, match="only during a simulation; start it first"):
        people.click(ui, 2)
    world.run(0)
    people.click(ui, 2)
    assert people.describe()[0]["visible"]
    assert world.call("simxGetUIEventButton", ui) == (2, [BUTTON, 1])


def test_a_copied_object_has_a_copy_of_its_ui_and_a_removed_one_none(world: World) -> None:
    (copy,) = world.call("simxCopyPasteObjects", [world.handle("robot")])
    assert names(world) == ["panel", "free", "panel#0"]
    assert world.parts.user_interface.old_uis.owner(world.call("simxGetUIHandle", "panel#0")) == copy
    world.call("simxRemoveModel", copy)
    assert names(world) == ["panel", "free"]


def test_a_ui_that_a_program_removed_is_not_copied(world: World) -> None:
    world.call("simxRemoveUI", world.call("simxGetUIHandle", "panel"))
    world.call("simxCopyPasteObjects", [world.handle("robot")])
    assert names(world) == ["free"]


def test_a_stop_reverts_copies_made_during_the_run(world: World) -> None:
    world.run(0)
    world.call("simxCopyPasteObjects", [world.handle("robot")])
    assert "panel#0" in names(world)
    world.call("simxStopSimulation")
    assert names(world) == ["panel", "free"]


def test_a_loaded_model_brings_its_ui_before_its_scripts_start(tmp_path: Path) -> None:
    pytest.importorskip("lupa")
    script = '<text name="simx:lua:customization:robot" data="print(simGetUIHandle([[panel]]) > 0)"/>'
    (tmp_path / "model.xml").write_text(scene(text("panel", object="robot"), script), encoding="utf-8")
    world = World(workspace=tmp_path)
    world.call("simxLoadModel", "model.xml", 0)
    assert names(world) == ["panel"]
    assert "true" in world.parts.status_bar.messages


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        ("no json", "must be a UI as JSON"),
        ("[1]", "must be a UI as JSON"),
        ('{"object": 7}', '"object" is the name of an object'),
        ('{"object": "nobody"}', "object=nobody, which is no object of the scene"),
        ("[" * 100_000, "must be a UI as JSON"),
    ],
)
def test_an_annotation_that_is_no_ui_is_refused_with_the_reason(data: str, reason: str) -> None:
    with pytest.raises(SceneError, match=reason):
        World(scene(f'<text name="simx:old_ui:panel" data={quoteattr(data)}/>'))


@pytest.mark.parametrize(
    "wrong",
    [
        {"properties": -1},
        {"size": [1]},
        {"element": [{"id": 1, "property": 4}]},
        {"element": [{"id": 1, "colors": [[2, 0, 0], None, None]}]},
        {"element": [{"id": 1, "colors": 3}]},
        {"other": 1},
    ],
)
def test_a_wrong_value_leaves_the_ui_out_and_says_why(
    wrong: dict[str, Any], caplog: pytest.LogCaptureFixture
) -> None:
    world = World(scene(text("panel", **wrong), text("free")))
    assert names(world) == ["free"]
    assert "the scene's UI 'panel' is not there" in caplog.text
