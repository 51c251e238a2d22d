"""Custom UIs. `user_interface/custom_uis.py` implements them, `custom_ui_files.py` reads their files."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.handlers.scene_files.loading import FILE_IS_ON_CLIENT, file_to_load
from simx_server.parts.user_interface.custom_ui_files import find_ui_file
from simx_server.parts.user_interface.custom_uis import MAX_LABEL, Element
from simx_server.scene.formats.texts.old_uis import check_property
from simx_server.service.calls.background import Steps
from simx_server.service.calls.registry import handler

if TYPE_CHECKING:
    from simx_server.service.clients.sessions import ClientSession
    from simx_server.world.world import World

_NO_EVENT = -1


def _element(world: World, ui: int, button: int, *kinds: str) -> Element:
    return world.user_interface.custom_uis.get(ui).widget(button, *kinds)


@handler("simxGetUIHandle")
def get_ui_handle(world: World, name: str) -> int:
    return world.user_interface.custom_uis.find(name)


@handler("simxGetUISlider")
def get_ui_slider(world: World, ui: int, button: int) -> int:
    return int(_element(world, ui, button, "slider").value)


@handler("simxSetUISlider")
def set_ui_slider(world: World, ui: int, button: int, position: int) -> None:
    """Clip the position to 0..1000; the call causes no event, since events are actions of people."""
    _element(world, ui, button, "slider").change(position)


@handler("simxGetUIEventButton")
def get_ui_event_button(world: World, ui: int) -> tuple[int, list[int]]:
    """Return the button and [its property, a slider's position or 1 down, 0 up], and remove the event.

    The call succeeds for an unknown UI too.

    Differs: events wait in a queue, so the second of two quick clicks is not lost; the original kept the last one.
    """
    uis = world.user_interface.custom_uis
    if ui not in uis or not uis.get(ui).events:
        return _NO_EVENT, [0, 0]
    event = uis.get(ui).events.popleft()
    return event.element, [event.prop, event.value]


@handler("simxGetUIButtonProperty")
def get_ui_button_property(world: World, ui: int, button: int) -> int:
    return _element(world, ui, button).prop


@handler("simxSetUIButtonProperty")
def set_ui_button_property(world: World, ui: int, button: int, prop: int) -> None:
    element = _element(world, ui, button)
    check_property(prop)
    element.set_property(prop)


@handler("simxSetUIButtonLabel")
def set_ui_button_label(world: World, ui: int, button: int, up: str | None, down: str | None) -> None:
    element = _element(world, ui, button)
    if up is not None:
        element.text = up[:MAX_LABEL]
    if down is not None:
        element.down_label = down[:MAX_LABEL]


@handler("simxLoadUI", with_client=True)
def load_ui(world: World, client: ClientSession, path: str, options: int) -> Steps[list[int]]:
    """Return the handles of the UIs in the file of the server's side or, with options bit 0, the client's.

    Differs: a UI is described in TOML or JSON; for a `.ttb` file the same name with such an ending is taken.
    """
    if not options & FILE_IS_ON_CLIENT:
        return (yield from world.user_interface.load(path))
    with file_to_load(world, client, path, options, lambda text: find_ui_file(world.simulation, text)) as (
        found,
        _,
    ):
        return (yield from world.user_interface.load(str(found)))


@handler("simxRemoveUI")
def remove_ui(world: World, ui: int) -> None:
    world.user_interface.custom_uis.remove(ui)
