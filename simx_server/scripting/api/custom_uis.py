"""V-REP 3's custom UIs: sliders, buttons and labels by number. `user_interface/custom_uis.py` explains them."""

from __future__ import annotations

from simx_server.handlers.user_interface import custom_uis

from .base import ApiPart


class CustomUIFunctions(ApiPart):
    """Functions for custom UIs. A slider's position is 0 to 1000."""

    def getUIHandle(self, name: str) -> int:
        """Return the handle of a UI. In a copied script, a name means the script's copy of the UI, if there is one."""
        own = self._adjusted(name)
        known = {ui.name for ui in self._world.user_interface.custom_uis}
        return custom_uis.get_ui_handle(self._world, own if own in known else name)

    def getUISlider(self, ui: int, button: int) -> int:
        return custom_uis.get_ui_slider(self._world, ui, button)

    def setUISlider(self, ui: int, button: int, position: int) -> None:
        custom_uis.set_ui_slider(self._world, ui, button, position)

    def getUIEventButton(self, ui: int) -> tuple[int, list[int]]:
        """Return the button that was operated (-1 for none), its property, and a slider's position or 1 for down, 0
        for up.
        """
        return custom_uis.get_ui_event_button(self._world, ui)

    def getUIButtonProperty(self, ui: int, button: int) -> int:
        return custom_uis.get_ui_button_property(self._world, ui, button)

    def setUIButtonProperty(self, ui: int, button: int, bits: int) -> None:
        custom_uis.set_ui_button_property(self._world, ui, button, bits)

    def getUIButtonLabel(self, ui: int, button: int) -> str:
        return self._world.user_interface.custom_uis.get(ui).element(button).label

    def setUIButtonLabel(self, ui: int, button: int, up: str, down: str | None = None) -> None:
        """Set the labels that a button shows when it is up and when it is down; nil: the same for both."""
        custom_uis.set_ui_button_label(self._world, ui, button, up, up if down is None else down)

    def removeUI(self, ui: int) -> None:
        custom_uis.remove_ui(self._world, ui)
