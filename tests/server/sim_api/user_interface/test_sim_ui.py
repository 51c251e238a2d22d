"""``simUI`` for scripts: windows from XML whose widgets call the script's functions."""

from __future__ import annotations

import base64
from typing import Any

import cv2
import numpy as np
import pytest
from scripted_world import said, scripted
from sim_api_calls import ScriptWorld, world

from simx_server.parts.user_interface.add_on import ADD_ON_NAME
from simx_server.parts.user_interface.contents.plot import Curve, Plot

__all__ = ["world"]

PANEL = """
<ui title="Panel" closeable="true" on-close="closed">
  <label text="Speed" id="1"/> <hslider minimum="0" maximum="100" value="20" on-change="changed" id="2"/>
  <button text="Go" on-click="clicked" id="3"/> <checkbox text="On" on-change="changed" id="4"/>
  <radiobutton text="A" id="5"/> <radiobutton text="B" id="6"/> <edit value="old" on-change="changed" id="7"/>
  <spinbox minimum="0" maximum="10" value="3" id="8"/> <progressbar id="9"/> <text-browser id="10"/>
  <combobox id="11"><item>one</item></combobox> <tabs id="12"><tab title="a"/><tab title="b"/></tabs>
  <table id="13"/> <tree id="14"/> <plot id="15"/> <image id="16"/> <button text="T" checkable="true" id="17"/>
</ui>
"""

HANDLERS = """
function clicked(ui, id) print('clicked', id) end
function changed(ui, id, value) print('changed', id, value) end
function closed(ui) print('closed') simUI.destroy(ui) end
"""


@pytest.fixture
def ui(world: ScriptWorld) -> int:
    world.lua(HANDLERS)
    return world.value(f"simUI.create([[{PANEL}]])")


def test_setters_keep_and_getters_give_back(world: ScriptWorld, ui: int) -> None:
    world.lua(
        f"""
        simUI.setLabelText({ui}, 1, 'Fast', true) simUI.setSliderValue({ui}, 2, 70.9, true)
        simUI.setCheckboxValue({ui}, 4, 2) simUI.setRadiobuttonValue({ui}, 6, 1) simUI.setEditValue({ui}, 7, 'new')
        simUI.setSpinboxValue({ui}, 8, 99) simUI.setProgress({ui}, 9, 40) simUI.setText({ui}, 10, 'a')
        simUI.appendText({ui}, 10, 'b') simUI.setButtonText({ui}, 3, 'Stop') simUI.setButtonPressed({ui}, 17, true)
        simUI.setCurrentTab({ui}, 12, 1) simUI.setEnabled({ui}, 3, false) simUI.setWidgetVisibility({ui}, 1, false)
        simUI.setTitle({ui}, 'Other') simUI.setPosition({ui}, 5, 6) simUI.setSize({ui}, 7, 8)
        """
    )
    assert world.lua(
        f"""return simUI.getLabelText({ui}, 1), simUI.getSliderValue({ui}, 2), simUI.getCheckboxValue({ui}, 4),
        simUI.getRadiobuttonValue({ui}, 5), simUI.getRadiobuttonValue({ui}, 6), simUI.getEditValue({ui}, 7),
        simUI.getSpinboxValue({ui}, 8), simUI.getCurrentTab({ui}, 12), simUI.getWidgetVisibility({ui}, 1),
        simUI.getTitle({ui}), simUI.isVisible({ui}), simUI.isWindowEnabled({ui})"""
    ) == ["Fast", 70, 2, 0, 1, "new", 10, 1, False, "Other", True, True]
    assert world.lua(f"return simUI.getPosition({ui})") == [5, 6]
    assert world.lua(f"return simUI.getSize({ui})") == [7, 8]
    shown = world.parts.user_interface.windows.get(ui)
    assert (shown.widget(9).value, shown.widget(10).text, shown.widget(17).value) == (40, "a\nb", 1)
    assert not shown.widget(3).is_usable
    assert said(world)[-1:] != ["changed"], "setters suppress events unless they are told not to"


def test_a_setter_that_does_not_suppress_events_calls_the_script(world: ScriptWorld, ui: int) -> None:
    said(world)
    world.lua(f"simUI.setSliderValue({ui}, 2, 30, false) simUI.setEditValue({ui}, 7, 'x', false)")
    assert said(world) == ["changed, 2, 30", "changed, 7, x"]


def test_a_user_operates_it_over_the_add_on_and_the_script_is_called(world: ScriptWorld, ui: int) -> None:
    def act(function: str, *numbers: int, text: str | None = None) -> None:
        strings = [] if text is None else [text]
        world.call("simxCallScriptFunction", ADD_ON_NAME, 2, function, list(numbers), [], strings, b"")

    said(world)
    act("pressWidget", ui, 3)
    act("enterValue", ui, 2, text="55")
    act("enterValue", ui, 4, text="2")
    act("closeWindow", ui)
    assert said(world) == ["clicked, 3", "changed, 2, 55", "changed, 4, 2", "closed"]
    world.fails(f"simUI.getTitle({ui})", "no UI with handle")


def test_an_error_in_a_function_is_printed_and_the_script_goes_on(world: ScriptWorld) -> None:
    ui = world.value(
        'simUI.create(\'<ui><button on-click="bad" id="1"/><button on-click="none" id="2"/></ui>\')'
    )
    world.lua("function bad() error('my fault') end")
    said(world)
    world.parts.user_interface.windows.get(ui).press(1)
    world.parts.user_interface.windows.get(ui).press(2)
    first, second = said(world)
    assert "my fault" in first
    assert "has no function 'none'" in second
    assert world.value("1 + 1") == 2


def test_combo_boxes(world: ScriptWorld, ui: int) -> None:
    world.lua(f"simUI.insertComboboxItem({ui}, 11, 99, 'two') simUI.insertComboboxItem({ui}, 11, 0, 'zero')")
    assert world.value(f"simUI.getComboboxItems({ui}, 11)") == ["zero", "one", "two"]
    assert world.value(f"simUI.getComboboxSelectedIndex({ui}, 11)") == 1, "the same item stays selected"
    world.lua(f"simUI.removeComboboxItem({ui}, 11, 0) simUI.setComboboxSelectedIndex({ui}, 11, 1)")
    assert world.lua(
        f"return simUI.getComboboxItemText({ui}, 11, 1), simUI.getComboboxItemCount({ui}, 11),"
        f"simUI.getComboboxSelectedIndex({ui}, 11)"
    ) == ["two", 2, 1]
    world.lua(f"simUI.setComboboxItems({ui}, 11, {{'a', 'b', 'c'}}, 2)")
    assert world.value(f"simUI.getComboboxSelectedIndex({ui}, 11)") == 2
    world.fails(f"simUI.setComboboxSelectedIndex({ui}, 11, 3)", "has 3 items; 3 is not one")
    world.fails(f"simUI.removeComboboxItem({ui}, 11, -1)", "is not one of them")
    world.goes_on(f"simUI.getComboboxItemText({ui}, 11, -1)", "those count from 0")


def test_tables_are_kept_and_shown(world: ScriptWorld, ui: int) -> None:
    world.lua(
        f"""
        simUI.setColumnCount({ui}, 13, 2) simUI.setRowCount({ui}, 13, 1) simUI.setItem({ui}, 13, 0, 1, 'x')
        simUI.setRowHeaderText({ui}, 13, 0, 'first') simUI.setColumnHeaderText({ui}, 13, 1, 'second')
        simUI.insertTableRow({ui}, 13, 0)
        """
    )
    assert world.lua(
        f"return simUI.getRowCount({ui}, 13), simUI.getColumnCount({ui}, 13), simUI.getItem({ui}, 13, 1, 1)"
    ) == [2, 2, "x"]
    kept = world.parts.user_interface.windows.get(ui).widget(13).kept
    assert kept == {"columns": ["", "second"], "rows": [["", ""], ["", "x"]], "names": ["", "first"]}
    world.lua(f"simUI.removeTableRow({ui}, 13, 0)")
    assert kept["rows"] == [["", "x"]]
    world.lua(f"simUI.insertTableColumn({ui}, 13, 1)")
    assert (kept["columns"], kept["rows"]) == (["", "", "second"], [["", "", "x"]])
    world.lua(f"simUI.removeTableColumn({ui}, 13, 0)")
    assert (kept["columns"], kept["rows"]) == (["", "second"], [["", "x"]])
    world.goes_on(f"simUI.removeTableColumn({ui}, 13, 2)", "has 2 columns, from 0; 2 is not one", 1)
    world.goes_on(f"simUI.getItem({ui}, 13, 1, 0)", "has 1 rows and 2 columns, from 0")
    world.goes_on(f"simUI.setRowCount({ui}, 13, 1000000)", "at most 10000 cells", 1)
    assert world.lua(f"return simUI.setColumnCount({ui}, 13, -1)") == [1]
    world.lua(f"simUI.clearTable({ui}, 13)")
    assert world.value(f"simUI.getRowCount({ui}, 13)") == 0


def test_a_plot_is_shown_with_its_ranges_labels_and_styles(world: ScriptWorld, ui: int) -> None:
    def shown() -> dict[str, Any]:
        (view,) = [each for each in world.parts.user_interface.view()["windows"] if each["handle"] == ui]
        (plot,) = [each["plot"] for each in view["widgets"] if each["id"] == 15]
        return plot

    assert shown() == {"x": (0, 1), "y": (0, 1), "labels": ["", ""], "legend": False, "curves": []}
    world.lua(
        f"""
        simUI.addCurve({ui}, 15, simUI.curve_type.xy, 'path', {{255, 300, -1}}, simUI.curve_style.line_and_scatter,
            {{scatter_size = 6, line_size = 2, line_style = simUI.line_style.dashed, add_to_legend = false}})
        simUI.addCurveXYPoints({ui}, 15, 'path', {{2, 1, 3}}, {{4, 0, 8}}, {{1, 0, -1}})
        simUI.setPlotXLabel({ui}, 15, 'metres') simUI.setPlotYLabel({ui}, 15, 'up')
        simUI.setLegendVisibility({ui}, 15, true)
        """
    )
    plot = shown()
    assert (plot["x"], plot["y"], plot["labels"], plot["legend"]) == ((0, 8), (-1, 1), ["metres", "up"], True)
    assert plot["curves"] == [
        {
            "name": "path",
            "color": (255, 255, 0),
            "style": "line_and_scatter",
            "line": 2,
            "scatter": 6,
            "dashed": True,
            "listed": False,
            "points": [(0, 0), (4, 1), (8, -1)],
        }
    ]
    world.lua(
        f"""
        simUI.setPlotRanges({ui}, 15, 0, 1, 2, -2) simUI.growPlotRanges({ui}, 15, -1, 1, 0, 1)
        simUI.growPlotXRange({ui}, 15, 0, 1) simUI.growPlotYRange({ui}, 15, 0, 1)
        """
    )
    assert (shown()["x"], shown()["y"]) == ((-1, 3), (-2, 4))
    world.lua(f"simUI.rescaleAxes({ui}, 15, 'path', false, true)")
    assert (shown()["x"], shown()["y"]) == ((0, 8), (-2, 4))
    world.lua(f"simUI.setPlotXRange({ui}, 15, 3, 5) simUI.setPlotYRange({ui}, 15, 3, 5)")
    world.lua(f"simUI.rescaleAxesAll({ui}, 15, true, false)")
    assert (shown()["x"], shown()["y"]) == ((0, 8), (-1, 1))
    world.fails(
        f"simUI.setPlotXRange({ui}, 15, 0, 1e308) simUI.growPlotXRange({ui}, 15, 0, 1e308)", "too large"
    )


def test_a_long_curve_is_shown_by_some_of_its_points() -> None:
    curve = Curve()
    curve.add([], [float(x) for x in range(10_500)], [0.0] * 10_500)
    plot = Plot({"long": curve})
    points = plot.view()["curves"][0]["points"]
    assert (len(points), points[0], points[-1]) == (300, (500, 0), (10_499, 0))
    assert plot.extent()[1] == (-0.5, 0.5)


def test_curves_keep_their_newest_points(world: ScriptWorld, ui: int) -> None:
    world.lua(
        f"""
        simUI.addCurve({ui}, 15, simUI.curve_type.time, 'y', {{255, 0, 0}}, simUI.curve_style.line, {{cyclic=true}})
        simUI.addCurveTimePoints({ui}, 15, 'y', {{0, 1}}, {{5, 6}}) simUI.replot({ui}, 15)
        simUI.setPlotLabels({ui}, 15, 'x', 'y') simUI.rescaleAxesAll({ui}, 15)
        """
    )
    assert world.lua(f"return simUI.getCurveData({ui}, 15, 'y')") == [[], [0, 1], [5, 6]]
    world.lua(f"simUI.clearCurve({ui}, 15, 'y') simUI.addCurveXYPoints({ui}, 15, 'y', {{0}}, {{1}}, {{2}})")
    assert world.lua(f"return simUI.getCurveData({ui}, 15, 'y')") == [[0], [1], [2]]
    world.lua(f"simUI.removeCurve({ui}, 15, 'y')")
    world.fails(f"simUI.clearCurve({ui}, 15, 'y')", "has no curve 'y'")
    assert world.value("sim_customui_curve_type_time == simUI.curve_type.time") is True


def test_what_is_not_shown_is_kept_and_said_once(world: ScriptWorld) -> None:
    world.value("simUI.create([[<ui><scene3d id='1'/><webview id='2'/><tree id='3'/></ui>]])")
    told = [line for line in world.parts.status_bar.messages if "kept and not shown" in line]
    assert told == ["simUI: these widgets are kept and not shown: scene3d, webview"]


def widget(world: ScriptWorld, ui: int, number: int) -> dict[str, Any]:
    """Return the view of a widget."""
    (view,) = [each for each in world.parts.user_interface.view()["windows"] if each["handle"] == ui]
    return next(each for each in view["widgets"] if each["id"] == number)


def test_a_tree_shows_the_items_that_are_expanded(world: ScriptWorld, ui: int) -> None:
    def shown() -> list[tuple[int, list[str], bool]]:
        return [(row["depth"], row["texts"], row["selected"]) for row in widget(world, ui, 14)["tree"]]

    world.lua(
        f"""
        simUI.addTreeItem({ui}, 14, 1, {{'robot', 'model'}}, 0, true) simUI.addTreeItem({ui}, 14, 2, {{'arm'}}, 1)
        simUI.addTreeItem({ui}, 14, 3, {{'hand'}}, 2) simUI.addTreeItem({ui}, 14, 4, {{'floor'}})
        simUI.setTreeSelection({ui}, 14, 2)
        """
    )
    assert shown() == [(0, ["robot", "model"], False), (1, ["arm"], True), (0, ["floor"], False)]
    world.lua(f"simUI.expandAll({ui}, 14) simUI.updateTreeItemText({ui}, 14, 3, {{'gripper'}})")
    assert [row[:2] for row in shown()][2] == (2, ["gripper"])
    world.lua(f"simUI.collapseAll({ui}, 14)")
    assert len(shown()) == 2
    world.lua(f"simUI.expandToDepth({ui}, 14, 0)")
    assert len(shown()) == 3
    world.lua(f"simUI.updateTreeItemParent({ui}, 14, 2, 4) simUI.expandAll({ui}, 14)")
    assert [row[0] for row in shown()] == [0, 0, 1, 2]
    world.fails(f"simUI.updateTreeItemParent({ui}, 14, 4, 3)", "cannot be below itself")
    world.fails(f"simUI.addTreeItem({ui}, 14, 2, {{'arm'}}, 3)", "cannot be below itself")
    world.lua(f"simUI.removeTreeItem({ui}, 14, 2)")
    assert [row[1] for row in shown()] == [["robot", "model"], ["floor"]]
    world.lua(f"simUI.clearTree({ui}, 14)")
    assert shown() == []


def test_an_item_0_of_a_tree_has_nothing_below_it(world: ScriptWorld, ui: int) -> None:
    world.lua(
        f"""
        simUI.clearTree({ui}, 14) simUI.addTreeItem({ui}, 14, 0, {{'zero'}}, 0, true)
        simUI.addTreeItem({ui}, 14, 5, {{'five'}}, 0) simUI.updateTreeItemParent({ui}, 14, 0, 5)
        simUI.expandAll({ui}, 14) simUI.updateTreeItemParent({ui}, 14, 5, 0)
        """
    )
    rows = widget(world, ui, 14)["tree"]
    assert [(row["depth"], row["texts"]) for row in rows] == [(0, ["five"]), (1, ["zero"])]
    world.lua(f"simUI.removeTreeItem({ui}, 14, 0)")
    assert [row["texts"] for row in widget(world, ui, 14)["tree"]] == [["five"]]
    world.lua(f"simUI.clearTree({ui}, 14)")


def test_an_image_is_shown(world: ScriptWorld, ui: int) -> None:
    assert widget(world, ui, 16)["png"] == ""
    world.lua(f"simUI.setImageData({ui}, 16, string.char(255, 0, 0, 0, 0, 255), 2, 1)")
    png = np.frombuffer(base64.b64decode(widget(world, ui, 16)["png"]), np.uint8)
    assert np.asarray(cv2.imdecode(png, cv2.IMREAD_COLOR)).tolist() == [[[0, 0, 255], [255, 0, 0]]]
    world.lua(f"simUI.setImageData({ui}, 16, string.rep('abc', 640 * 20), 640, 20)")
    png = np.frombuffer(base64.b64decode(widget(world, ui, 16)["png"]), np.uint8)
    assert np.asarray(cv2.imdecode(png, cv2.IMREAD_COLOR)).shape == (10, 320, 3)
    world.fails(f"simUI.setImageData({ui}, 16, 'abc', 2, 1)", "2 x 1 pixels have 6 bytes, not 3")
    world.fails(f"simUI.setImageData({ui}, 16, 'abc', 0, 1)", "1 to 4096 pixels a side")


def test_an_item_that_is_not_there_is_told(world: ScriptWorld, ui: int) -> None:
    world.goes_on(f"simUI.updateTreeItemText({ui}, 14, 1, {{'b'}})", "the tree has no item 1", -1)


def test_dialogs_are_closed_at_once(world: ScriptWorld) -> None:
    assert world.lua(
        "return simUI.msgBox(simUI.msgbox_type.info, simUI.msgbox_buttons.ok, 'T', 'M') == simUI.msgbox_result.ok,"
        "simUI.msgBox(1, simUI.msgbox_buttons.yesno, 'T', 'M') == simUI.msgbox_result.no, simUI.inputDialog('a')"
    )[:2] == [True, True]
    assert world.parts.status_bar.messages.count("T: M") == 2
    assert world.value("#simUI.fileDialog(simUI.filedialog_type.load, 't', '', '', '', '')") == 0


def test_the_old_names_reach_the_same_functions(world: ScriptWorld) -> None:
    ui = world.value('simExtCustomUI_create(\'<ui title="Old"><label id="1" text="a"/></ui>\')')
    world.lua(f"simExtCustomUI_setLabelText({ui}, 1, 'b') simExtCustomUI_hide({ui})")
    assert world.lua(f"return simExtCustomUI_getLabelText({ui}, 1), simUI.isVisible({ui})") == ["b", False]
    world.lua(f"simUI.show({ui}) simUI.hide({ui}) simUI.setWindowEnabled({ui}, false)")
    assert world.lua(f"return simUI.isVisible({ui}), simUI.isWindowEnabled({ui})") == [False, False]
    world.lua(f"simExtCustomUI_destroy({ui})")
    world.fails(f"simExtCustomUI_show({ui})", "no UI with handle")
    assert world.value("simExtCustomUI_noSuch == nil") is True


def window_of(world: Any) -> list[str]:
    return [each["title"] for each in world.parts.user_interface.describe()["windows"]]


def test_windows_end_with_the_script_that_made_them() -> None:
    text = "function sysCall_init() simUI.create('<ui title=\"{0}\"/>') end"
    world = scripted({"lua:base": text.format("child"), "lua:customization:base": text.format("kept")})
    assert window_of(world) == ["kept"]
    world.run(1)
    assert window_of(world) == ["kept", "child"]
    world.call("simxStopSimulation")
    assert window_of(world) == ["kept"]


def test_there_is_a_limit_to_windows(world: ScriptWorld) -> None:
    world.fails("for i = 1, 1000 do simUI.create('<ui/>') end", "remove some with simUI.destroy")


def test_python_scripts_make_windows_too() -> None:
    source = """
    def sysCall_init():
        self.ui = simUI.create('<ui><button on-click="clicked" id="1"/></ui>')
    def clicked(ui, number):
        print('clicked', number)
    """
    world = scripted({"python:base": source})
    world.run(1)
    world.parts.user_interface.windows.get(1).press(1)
    lines = said(world)
    world.parts.scripts.close()
    assert "clicked 1" in lines


TABLE = """<ui><table id='1' on-selection-change='chosen'><header><item>name</item><item>value</item></header>
<row><item>a</item><item>1</item></row><row><item>b</item><item>2</item></row></table><tree id='2'/></ui>"""


def test_a_cell_is_selected_and_the_script_hears_of_it(world: ScriptWorld) -> None:
    world.lua("function chosen(ui, id, row, column) picked = {row, column} end")
    ui = world.value(f"simUI.create([[{TABLE}]])")
    world.lua(f"simUI.setTableSelection({ui}, 1, 1, 0)")
    assert widget(world, ui, 1)["selected"] == (1, 0)
    assert world.value("picked == nil") is True
    world.lua(f"simUI.setTableSelection({ui}, 1, 0, 1, false)")
    assert world.value("picked") == [0, 1]
    world.lua(f"simUI.setTableSelection({ui}, 1, 9, 0)")
    assert "no cell 9, 0" in world.parts.status_bar.messages[-1]
    assert widget(world, ui, 1)["selected"] == (0, 1)


def test_sizes_of_columns_and_rows_are_shown_saved_and_restored(world: ScriptWorld) -> None:
    ui = world.value(f"simUI.create([[{TABLE}]])")
    world.lua(f"simUI.setColumnWidth({ui}, 1, 0, 50, 80) simUI.setRowHeight({ui}, 1, 1, 20)")
    assert (widget(world, ui, 1)["widths"], widget(world, ui, 1)["heights"]) == (
        {0: (50, 80)},
        {1: (20, 10_000)},
    )
    world.lua(f"state = simUI.saveState({ui}, 1) simUI.setColumnWidth({ui}, 1, 0, 5, 8)")
    world.lua(f"simUI.restoreState({ui}, 1, state) simUI.setColumnWidth({ui}, 2, 1, 30, 30)")
    assert widget(world, ui, 1)["widths"] == {0: (50, 80)}
    assert widget(world, ui, 2)["widths"] == {1: (30, 30)}
    world.fails(f"simUI.restoreState({ui}, 1, 'x')", "not a state that simUI.saveState has returned")
    world.fails(f"simUI.setColumnWidth({ui}, 1, -1, 5)", "count from 0")


def test_vector_graphics_are_shown(world: ScriptWorld) -> None:
    ui = world.value("simUI.create([[<ui><svg id='1'/></ui>]])")
    world.lua(f"simUI.svgLoadData({ui}, 1, '<svg/>')")
    assert widget(world, ui, 1)["svg"] == "<svg/>"
    (world.sim.files.workspace / "mark.svg").write_text("<svg id='m'/>")
    world.lua(f"simUI.svgLoadFile({ui}, 1, 'mark.svg')")
    assert widget(world, ui, 1)["svg"] == "<svg id='m'/>"
    world.fails(f"simUI.svgLoadFile({ui}, 1, 'none.svg')", "there is no file 'none.svg'")
    world.fails(f"simUI.svgLoadData({ui}, 1, string.rep(' ', 100001))", "at most 100000 characters")


def test_a_banner_has_buttons_that_call_a_function(world: ScriptWorld) -> None:
    world.lua("function pressed(key) answer = key end")
    banner = world.value("simUI.bannerCreate('Save?', {'y', 'n'}, {'Yes', 'No'}, 'pressed')")
    assert [widget(world, banner, number)["text"] for number in (1, 2, 3)] == ["Save?", "Yes", "No"]
    press = world.parts.scripts.add_ons["simxUserInterface"].call
    press("pressWidget", [banner, 3], [], [], b"")
    assert world.value("answer") == "n"
    world.lua(f"simUI.bannerDestroy({banner})")
    world.fails(f"simUI.bannerDestroy({banner})", "there are: ")
    world.fails("simUI.bannerCreate('x', {'y'}, {})", "a key and a label for each button")


def test_formats_of_images_are_those_that_can_be_read(world: ScriptWorld) -> None:
    formats, text = world.lua("return simUI.supportedImageFormats(';')")
    assert text == ";".join(formats)
    assert {"png", "svg"} <= set(formats)
