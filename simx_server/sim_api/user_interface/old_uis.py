"""V-REP 3's custom UIs: sliders, buttons and labels by number. `parts/user_interface/custom_uis.py` explains them."""

from __future__ import annotations

from types import MappingProxyType

from simx_client.protocol import constants as c
from simx_server.errors import CommandError
from simx_server.handlers.user_interface import custom_uis
from simx_server.parts.user_interface.custom_uis import Color, CustomUI, Element
from simx_server.sim_api.base import ApiPart

from .sim_ui_plots import OLD_CONSTANTS

_TITLE = c.sim_buttonproperty_label | c.sim_buttonproperty_enabled | c.sim_buttonproperty_verticallycentered
_ACTION = c.sim_buttonproperty_enabled | c.sim_buttonproperty_verticallycentered
_MINIMIZE = _ACTION | c.sim_buttonproperty_staydown | c.sim_buttonproperty_rollupaction
_CLOSE = _ACTION | c.sim_buttonproperty_closeaction

_LARGEST = 10_000
"""Most columns, rows and pixels of a UI."""


class CustomUIFunctions(ApiPart):
    """Functions for custom UIs. A slider's position is 0 to 1000; places and sizes of buttons are in cells."""

    CONSTANTS = MappingProxyType(
        {"ui_property_systemblockcanmovetofront": 0x800, "ui_property_pauseactive": 0x1000, **OLD_CONSTANTS}
    )

    def getUIHandle(self, name: str) -> int:
        """Return the handle of a UI. In a copied script, a name means the script's copy of the UI, if there is one.
        With ``name@silentError`` an unknown name gives -1.
        """
        plain, _, suffix = name.partition("@")
        own = self._adjusted(plain)
        known = {ui.name for ui in self._world.user_interface.custom_uis}
        found = own if own in known else plain
        if found not in known and suffix.lower() == "silenterror":
            return -1
        return custom_uis.get_ui_handle(self._world, found)

    def createUI(
        self, name: str, menu: int, client_size: list[int], cell_size: list[int] | None = None
    ) -> tuple[int, list[int]]:
        """Create a UI and return its handle, and the handles of the buttons of its title bar. `menu`:
        sim.ui_menu_title, _minimize and _close; the sizes are columns and rows, and a cell's pixels.
        """
        columns, rows = _pair(client_size, "the size")
        _pair(cell_size or [14, 14], "the size of a cell")
        wanted = [
            (bit, label, prop)
            for bit, label, prop in (
                (c.sim_ui_menu_title, name, _TITLE),
                (c.sim_ui_menu_minimize, "&&Minimize", _MINIMIZE),
                (c.sim_ui_menu_close, "&&Cross", _CLOSE),
            )
            if menu & bit
        ]
        others = sum(bit != c.sim_ui_menu_title for bit, _, _ in wanted)
        elements: dict[int, Element] = {}
        column = 0
        for number, (bit, label, prop) in enumerate(wanted):
            width = max(1, columns - others) if bit == c.sim_ui_menu_title else 1
            elements[number] = Element(number, prop, label, place=[column, 0, width, 1])
            column += width
        ui = CustomUI(name, name, elements, size=(columns, rows + bool(wanted)))
        self._world.user_interface.custom_uis.add(ui)
        return ui.handle, list(elements)

    def createUIButton(self, ui: int, position: list[int], size: list[int], bits: int) -> int:
        """Add a button, label, slider or edit box to a UI and return its handle. `bits`: sim.buttonproperty_*."""
        place = [*_pair(position, "the position", least=0), *_pair(size, "the size")]
        return self._world.user_interface.custom_uis.add_element(ui, bits, place)

    def getUIProperty(self, ui: int) -> int:
        """Return the sim.ui_property_* bits of a UI."""
        return self._world.user_interface.custom_uis.get(ui).properties

    def setUIProperty(self, ui: int, bits: int) -> int:
        """Set the sim.ui_property_* bits of a UI and return 1. A UI without sim.ui_property_visible is hidden.

        Partly: only visible, visibleduringsimulationonly and rolledup have an effect; the others are kept.
        """
        self._world.user_interface.custom_uis.set_properties(ui, bits)
        return 1

    def getUIPosition(self, ui: int) -> list[int]:
        """Return the position of a UI in pixels. Partly: it is the one that a script has set; nothing moves it."""
        return list(self._world.user_interface.custom_uis.get(ui).position)

    def setUIPosition(self, ui: int, position: list[int]) -> int:
        """Keep a position for a UI in pixels and return 1. Partly: the web viewer shows UIs one below the other."""
        x, y = _pair(position, "the position", least=-_LARGEST)
        self._world.user_interface.custom_uis.get(ui).position = x, y
        return 1

    def getUIButtonSize(self, ui: int, button: int) -> list[int]:
        """Return columns and rows of a button."""
        place = self._world.user_interface.custom_uis.get(ui).element(button).place
        return place[2:] if place else [1, 1]

    def setUIButtonColor(
        self,
        ui: int,
        button: int,
        up: list[float] | None = None,
        down: list[float] | None = None,
        label: list[float] | None = None,
    ) -> int:
        """Set the colours (RGB 0..1) of a button's background when it is up and down, and of its label; nil keeps a
        colour. Return 1.
        """
        colors = [None if each is None else _color(each) for each in (up, down, label)]
        self._world.user_interface.custom_uis.set_colors(ui, button, colors)
        return 1

    def createUIButtonArray(self, ui: int, button: int) -> int:
        """Return 1. Stand-in: the pixels that it adds to a button are not shown."""
        self._world.user_interface.custom_uis.get(ui).element(button)
        self._say_once("pixels on the buttons of custom UIs (sim.createUIButtonArray) are not shown")
        return 1

    def setUIButtonArrayColor(self, ui: int, button: int, _position: list[int], _color: list[float]) -> int:
        """Return 1. Stand-in: the pixels of a button are not shown."""
        self._world.user_interface.custom_uis.get(ui).element(button)
        return 1

    def deleteUIButtonArray(self, ui: int, button: int) -> int:
        """Return 1. Stand-in: the pixels of a button are not shown."""
        self._world.user_interface.custom_uis.get(ui).element(button)
        return 1

    def getUISlider(self, ui: int, button: int) -> int:
        return custom_uis.get_ui_slider(self._world, ui, button)

    def setUISlider(self, ui: int, button: int, position: int) -> int:
        custom_uis.set_ui_slider(self._world, ui, button, position)
        return 1

    def getUIEventButton(self, ui: int) -> tuple[int, list[int]]:
        """Return the button that was operated (-1 for none), its property, and a slider's position or 1 for down, 0
        for up.
        """
        return custom_uis.get_ui_event_button(self._world, ui)

    def getUIButtonProperty(self, ui: int, button: int) -> int:
        return custom_uis.get_ui_button_property(self._world, ui, button)

    def setUIButtonProperty(self, ui: int, button: int, bits: int) -> int:
        custom_uis.set_ui_button_property(self._world, ui, button, bits)
        return 1

    def getUIButtonLabel(self, ui: int, button: int) -> str:
        return self._world.user_interface.custom_uis.get(ui).element(button).label

    def setUIButtonLabel(self, ui: int, button: int, up: str | None, down: str | None = None) -> None:
        """Set the labels that a button shows when it is up and when it is down; nil leaves one as it is."""
        custom_uis.set_ui_button_label(self._world, ui, button, up, down)

    def removeUI(self, ui: int) -> int:
        custom_uis.remove_ui(self._world, ui)
        return 1

    # Names of V-REP 2.

    create2DElement = createUI
    create2DElementButton = createUIButton
    remove2DElement = removeUI
    get2DElementHandle = getUIHandle
    get2DElementProperty = getUIProperty
    set2DElementProperty = setUIProperty
    get2DElementPosition = getUIPosition
    set2DElementPosition = setUIPosition
    get2DElementSlider = getUISlider
    set2DElementSlider = setUISlider
    get2DElementEventButton = getUIEventButton
    get2DElementButtonProperty = getUIButtonProperty
    set2DElementButtonProperty = setUIButtonProperty
    get2DElementButtonSize = getUIButtonSize
    get2DElementButtonLabel = getUIButtonLabel
    set2DElementButtonLabel = setUIButtonLabel
    set2DElementButtonColor = setUIButtonColor
    create2DElementButtonArray = createUIButtonArray
    set2DElementButtonArrayColor = setUIButtonArrayColor
    delete2DElementButtonArray = deleteUIButtonArray


def _pair(numbers: list[int], what: str, least: int = 1) -> tuple[int, int]:
    if len(numbers) < 2 or not all(least <= number <= _LARGEST for number in numbers[:2]):
        raise CommandError(f"{what} must be two whole numbers from {least} to {_LARGEST}, not {numbers[:9]}")
    return numbers[0], numbers[1]


def _color(numbers: list[float]) -> Color:
    if len(numbers) < 3:
        raise CommandError(f"a colour must be three numbers from 0 to 1, not {numbers[:9]}")
    red, green, blue = (min(max(number, 0.0), 1.0) for number in numbers[:3])
    return red, green, blue
