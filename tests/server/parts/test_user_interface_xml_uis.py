"""Windows made from XML: how they are read, what their widgets do, and what hostile texts cannot."""

from __future__ import annotations

from typing import Any

import pytest

from simx_server.errors import CommandError
from simx_server.parts.user_interface.xml_windows.reading import (
    FIRST_ID,
    MAX_DEPTH,
    MAX_WIDGETS,
    MAX_XML,
    read_window,
)
from simx_server.parts.user_interface.xml_windows.windows import XmlWindow, XmlWindows
from simx_server.simulation.simulation import Simulation

pytestmark = pytest.mark.slow

ALL = """
<ui title="Drive" closeable="true" on-close="closed" position="10,20">
  <label text="R & D" id="1"/>
  <group id="2">
    <button text="Go" on-click="go" id="3"/>
    <button text="Hold" checkable="true" on-click="hold" id="4"/>
    <radiobutton text="A" on-click="choose" id="5" checked="true"/>
    <radiobutton text="B" on-click="choose" id="6"/>
  </group>
  <checkbox text="Light" onchange="light" id="7"/>
  <hslider minimum="-10" maximum="10" value="99" on-change="speed" id="8"/>
  <spinbox minimum="0" maximum="1" step="0.1" value="0.5" on-change="gain" id="9"/>
  <combobox on-change="pick" id="10"><item>one</item><item>two</item></combobox>
  <edit value="old" on-change="typed" on-editing-finished="done" id="11"/>
  <tabs id="12">
    <tab title="First" id="13"><label text="on the first" id="14"/></tab>
    <tab title="Second" id="15"><label text="on the second" id="16"/></tab>
  </tabs>
  <progressbar minimum="0" maximum="50" value="10" id="17"/>
  <table id="18"><header><item>x</item></header><row><item>1</item><item>2</item></row></table>
  <stretch/>
</ui>
"""


class Told(list[tuple[Any, ...]]):
    """The calls of a script's functions."""

    def __call__(self, function: str, values: tuple[Any, ...]) -> None:
        self.append((function, *values))


@pytest.fixture
def windows() -> XmlWindows:
    return XmlWindows(Simulation())


@pytest.fixture
def told() -> Told:
    return Told()


@pytest.fixture
def window(windows: XmlWindows, told: Told) -> XmlWindow:
    made = read_window(ALL)
    made.fire = told
    windows.add(made)
    return made


def test_a_text_becomes_widgets_with_their_values(window: XmlWindow) -> None:
    assert (window.title, window.position, window.is_closeable) == ("Drive", (10, 20), True)
    kinds = {number: widget.kind for number, widget in window.widgets.items()}
    assert (kinds[3], kinds[8], kinds[9], kinds[18]) == ("button", "slider", "spinbox", "table")
    assert window.widget(1).text == "R & D"
    assert window.widget(8).value == 10, "within its range"
    assert (window.widget(9).value, window.widget(9).is_float) == (0.5, True)
    assert (window.widget(10).items, window.widget(10).value) == (["one", "two"], 0)
    assert window.widget(12).items == ["First", "Second"]
    assert window.widget(18).kept["rows"] == [["1", "2"]]
    assert window.widget(18).kept["columns"] == ["x", ""]


def test_people_operate_widgets_and_the_script_is_told(
    windows: XmlWindows, window: XmlWindow, told: Told
) -> None:
    ui = window.handle
    windows.get(ui).press(3)
    windows.get(ui).press(4)
    windows.get(ui).press(6)
    windows.get(ui).press(7)
    windows.get(ui).press(7)
    windows.get(ui).enter(8, "-3")
    windows.get(ui).enter(9, "0.25")
    windows.get(ui).enter(10, "1")
    windows.get(ui).enter(11, "new")
    assert told == [
        ("go", ui, 3),
        ("hold", ui, 4),
        ("choose", ui, 6),
        ("light", ui, 7, 2),
        ("light", ui, 7, 0),
        ("speed", ui, 8, -3),
        ("gain", ui, 9, 0.25),
        ("pick", ui, 10, 1),
        ("typed", ui, 11, "new"),
        ("done", ui, 11, "new"),
    ]
    assert [window.widget(each).value for each in (4, 5, 6)] == [1, 0, 1], "one of a group is selected"
    windows.get(ui).press(4)
    assert window.widget(4).value == 0


def test_a_value_that_stays_the_same_is_no_event(windows: XmlWindows, window: XmlWindow, told: Told) -> None:
    windows.get(window.handle).enter(8, "10")
    window.set_value(window.widget(8), 10, fires=True)
    window.set_text(window.widget(11), "old", fires=True)
    assert told == []


def test_only_what_is_shown_and_enabled_can_be_used(windows: XmlWindows, window: XmlWindow) -> None:
    ui = window.handle
    assert not window.is_shown(window.widget(16))
    windows.get(ui).enter(12, "1")
    assert window.is_shown(window.widget(16))
    assert not window.is_shown(window.widget(14))
    window.widget(2).is_visible = False
    with pytest.raises(CommandError, match="is hidden"):
        windows.get(ui).press(3)
    window.widget(2).is_visible, window.widget(2).is_enabled = True, False
    with pytest.raises(CommandError, match="is not enabled"):
        windows.get(ui).press(3)
    with pytest.raises(CommandError, match="a slider, not a button"):
        windows.get(ui).press(8)
    for wrong in ("much", "nan", "inf", ""):
        with pytest.raises(CommandError, match="its value is a number"):
            windows.get(ui).enter(8, wrong)
    with pytest.raises(CommandError, match="2 items; 7 is not one"):
        windows.get(ui).enter(10, "7")
    with pytest.raises(CommandError, match="nothing can be entered"):
        windows.get(ui).enter(1, "x")
    with pytest.raises(CommandError, match="has no widget 99; it has: 1"):
        windows.get(ui).press(99)
    with pytest.raises(CommandError, match="no UI with handle 7; there are: 1"):
        windows.get(7).press(3)


def test_closing_asks_the_script_or_hides_the_window(
    windows: XmlWindows, window: XmlWindow, told: Told
) -> None:
    windows.get(window.handle).close()
    assert (told, window.is_visible) == ([("closed", window.handle)], True)
    plain = read_window("<ui closeable='true'/>")
    windows.get(*windows.add(plain)).close()
    assert not plain.is_visible
    with pytest.raises(CommandError, match="cannot be closed by its user"):
        windows.get(*windows.add(read_window("<ui/>"))).close()


def test_a_window_goes_with_its_script_and_with_the_scene(windows: XmlWindows, window: XmlWindow) -> None:
    window.is_alive = lambda: False
    with pytest.raises(CommandError, match="no UI with handle 1"):
        windows.get(window.handle)
    windows.forget_the_gone()
    assert len(windows) == 0
    windows.add(read_window("<ui/>"))
    windows.scene_changed()
    assert len(windows) == 0


def test_widgets_without_an_id_get_one() -> None:
    assert list(read_window("<ui><label/><label id='4'/><label/></ui>").widgets) == [
        FIRST_ID,
        4,
        FIRST_ID + 2,
    ]


def test_descriptions_are_plain_data(windows: XmlWindows, window: XmlWindow) -> None:
    described = window.view()
    by_id = {each["id"]: each for each in described["widgets"]}
    assert 13 not in by_id, "a tab is an item of its tabs"
    assert by_id[12]["items"] == ["First", "Second"]
    assert by_id[18]["rows"] == [["1", "2"]]
    assert by_id[16]["visible"] is False


@pytest.mark.parametrize(
    "text", ["<a " + "a" * MAX_XML, "<" + "a" * MAX_XML, "<?" * (MAX_XML // 2), "<!--" * (MAX_XML // 4)]
)
def test_a_text_without_ends_is_read_once(text: str) -> None:
    """A second look from each character would take hours."""
    with pytest.raises(CommandError, match="cannot be read"):
        read_window(text[:MAX_XML])


def test_a_text_is_read_as_by_the_lenient_parser_of_vrep() -> None:
    window = read_window(
        """<?xml version="1.0"?><!DOCTYPE ui><ui title="a < b &none; &lt;" title="second">
        <!-- x < y --><button text="<<" on-click='f' id="1"/><label id="2" text='&#65;&'>R & D\v</label></ui>"""
    )
    assert (window.title, window.widget(1).text) == ("a < b &none; <", "<<")
    assert window.widget(2).text == "A&"
    nested = "<<!a>!DOCTYPE x [<<!a>!ENTITY e 'long'>]><ui title='&e;'/>"
    assert read_window(nested).title == "&e;", "no entity is defined by a text"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("<ui", "cannot be read"),
        ("", "cannot be read"),
        ("<window/>", "must begin with <ui>"),
        ("<ui><label id='1'/><label id='1'/></ui>", "two widgets with id 1"),
        ("<ui><label id='x'/></ui>", "is not a number"),
        ("<ui><label id='1e99'/></ui>", "is not a number of 32 bits"),
        ("<!DOCTYPE x [<!ENTITY a 'b'>]><ui><label text='&a;'/></ui>", "cannot be read"),
        ("<ui>" + "<label/>" * (MAX_WIDGETS + 1) + "</ui>", "more than 1000 widgets"),
        ("<ui>" + "<group>" * (MAX_DEPTH + 1) + "</group>" * (MAX_DEPTH + 1) + "</ui>", "nested deeper"),
        ("<ui>" + " " * MAX_XML + "</ui>", "at most 200000"),
    ],
    ids=range(10),
)
def test_a_text_that_is_no_ui_is_refused_with_the_reason(text: str, reason: str) -> None:
    with pytest.raises(CommandError, match=reason):
        read_window(text)
