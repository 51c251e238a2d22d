"""Values of the widgets of ``simUI``: sliders, boxes, texts.

With `suppress` false, a change calls the script's function as a change by the user does.
"""

from __future__ import annotations

from simx_server.errors import Unsupported
from simx_server.parts.user_interface.xml_uis.widgets import CHECKED, MAX_ITEMS, MAX_TEXT, Widget

from .sim_ui import UiPart


class UiValueFunctions(UiPart):
    """Widgets with a value, in their windows."""

    def _number(self, handle: int, id: int, kind: str) -> int:
        return int(self._widget(handle, id, kind).value)

    def _put(self, handle: int, id: int, kind: str, value: float, suppress: bool) -> None:
        window = self._window(handle)
        window.set_value(window.widget(id, kind), value, fires=not suppress)

    def _put_text(self, handle: int, id: int, kind: str, text: str, suppress: bool = True) -> None:
        window = self._window(handle)
        window.set_text(window.widget(id, kind), text, fires=not suppress)

    def getSliderValue(self, handle: int, id: int) -> int:
        return self._number(handle, id, "slider")

    def setSliderValue(self, handle: int, id: int, value: float, suppress: bool = True) -> None:
        """Set the position of a slider, within its range; a fraction is rounded down."""
        self._put(handle, id, "slider", value // 1, suppress)

    def getSpinboxValue(self, handle: int, id: int) -> float:
        return self._widget(handle, id, "spinbox").value

    def setSpinboxValue(self, handle: int, id: int, value: float, suppress: bool = True) -> None:
        """Set the number of a spin box, within its range."""
        self._put(handle, id, "spinbox", value, suppress)

    def getCheckboxValue(self, handle: int, id: int) -> int:
        """Return 2 for a check box that is checked, else 0."""
        return self._number(handle, id, "checkbox")

    def setCheckboxValue(self, handle: int, id: int, value: int, suppress: bool = True) -> None:
        """Set a check box: 0, or 2 for checked."""
        self._put(handle, id, "checkbox", CHECKED if value else 0, suppress)

    def getRadiobuttonValue(self, handle: int, id: int) -> int:
        """Return 1 for a radio button that is selected, else 0."""
        return self._number(handle, id, "radiobutton")

    def setRadiobuttonValue(self, handle: int, id: int, value: int, suppress: bool = True) -> None:
        """Select a radio button, and so release the others of its group."""
        self._put(handle, id, "radiobutton", 1 if value else 0, suppress)

    def setButtonPressed(self, handle: int, id: int, pressed: bool) -> None:
        """Press or release a checkable button."""
        self._put(handle, id, "button", int(pressed), True)

    def setButtonText(self, handle: int, id: int, text: str) -> None:
        self._put_text(handle, id, "button", text)

    def getEditValue(self, handle: int, id: int) -> str:
        return self._widget(handle, id, "edit").text

    def setEditValue(self, handle: int, id: int, value: str, suppress: bool = True) -> None:
        """Set the text of an edit box."""
        self._put_text(handle, id, "edit", value, suppress)

    def getLabelText(self, handle: int, id: int) -> str:
        return self._widget(handle, id, "label").text

    def setLabelText(self, handle: int, id: int, text: str, suppress: bool = True) -> None:
        """Set the text of a label."""
        self._put_text(handle, id, "label", text, suppress)

    def setText(self, handle: int, id: int, text: str, suppress: bool = True) -> None:
        """Set the text of a text browser. Partly: HTML is shown as it is written."""
        self._put_text(handle, id, "text-browser", text, suppress)

    def appendText(self, handle: int, id: int, text: str, suppress: bool = True) -> None:
        """Append a line to a text browser; the oldest part of a long text is dropped. Partly: as setText."""
        old = self._widget(handle, id, "text-browser").text
        self._put_text(handle, id, "text-browser", f"{old}\n{text}"[-MAX_TEXT:] if old else text, suppress)

    def setProgress(self, handle: int, id: int, value: float) -> None:
        """Set the value of a progress bar, within its range."""
        self._put(handle, id, "progressbar", value, True)

    def getCurrentTab(self, handle: int, id: int) -> int:
        """Return the index of the tab that is shown, from 0."""
        return self._number(handle, id, "tabs")

    def setCurrentTab(self, handle: int, id: int, index: int, _suppress: bool = True) -> None:
        """Show a tab, by its index from 0."""
        tabs = self._widget(handle, id, "tabs")
        if not 0 <= index < max(1, len(tabs.items)):
            raise Unsupported(f"widget {id} has {len(tabs.items)} tabs; {index} is not one of them")
        tabs.value = index

    def setEnabled(self, handle: int, id: int, enabled: bool, _suppress: bool = True) -> None:
        """Enable or disable a widget, and with a group what is in it."""
        self._widget(handle, id).is_enabled = enabled

    def getWidgetVisibility(self, handle: int, id: int) -> bool:
        return self._widget(handle, id).is_visible

    def setWidgetVisibility(self, handle: int, id: int, visible: bool) -> None:
        """Show or hide a widget, and with a group what is in it."""
        self._widget(handle, id).is_visible = visible

    def getCurrentEditWidget(self, handle: int) -> int:
        """Return the edit box with the cursor. Stand-in: always -1, as the server is not told."""
        self._window(handle)
        return -1

    def setCurrentEditWidget(self, handle: int, id: int) -> None:
        """Do nothing to an existing edit box. Stand-in: the cursor belongs to the user."""
        if id != -1:
            self._widget(handle, id, "edit")


class UiComboboxFunctions(UiPart):
    """Combo boxes. Items are counted from 0."""

    def _box(self, handle: int, id: int) -> Widget:
        return self._widget(handle, id, "combobox")

    def insertComboboxItem(self, handle: int, id: int, index: int, text: str, _suppress: bool = True) -> None:
        """Insert an item; an index beyond the end appends it."""
        self._box(handle, id).insert_item(index, text)

    def removeComboboxItem(self, handle: int, id: int, index: int, _suppress: bool = True) -> None:
        self._box(handle, id).remove_item(index)

    def getComboboxItemCount(self, handle: int, id: int) -> int:
        return len(self._box(handle, id).items)

    def getComboboxItemText(self, handle: int, id: int, index: int) -> str:
        box = self._box(handle, id)
        if index < 0:
            raise Unsupported(f"{index} is not the index of an item; those count from 0")
        return box.items[box.index_of_item(index)]

    def getComboboxItems(self, handle: int, id: int) -> list[str]:
        return list(self._box(handle, id).items)

    def setComboboxItems(
        self, handle: int, id: int, items: list[str], index: int, suppress: bool = True
    ) -> None:
        """Replace all items and select one, -1 for none."""
        if len(items) > MAX_ITEMS:
            raise Unsupported(f"a combo box has at most {MAX_ITEMS} items, not {len(items)}")
        box = self._box(handle, id)
        box.items = [item[:MAX_TEXT] for item in items]
        box.value = -1
        self._window(handle).set_value(box, min(index, len(items) - 1), fires=not suppress)

    def getComboboxSelectedIndex(self, handle: int, id: int) -> int:
        """Return the index of the selected item, -1 for none."""
        return int(self._box(handle, id).value)

    def setComboboxSelectedIndex(self, handle: int, id: int, index: int, suppress: bool = True) -> None:
        """Select an item, -1 for none."""
        self._window(handle).set_value(self._box(handle, id), index, fires=not suppress)
