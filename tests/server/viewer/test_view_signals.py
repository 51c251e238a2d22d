"""The Signals tab: what is set on the page is read over the API; plots grow with simulated time, and only then."""

from __future__ import annotations

import copy
import os
import sys
from collections.abc import Iterator
from queue import Queue
from typing import Any

import mujoco
import numpy as np
import pytest

pytest.importorskip("viser", reason="needs the extra viewer")

from page_elements import Elements, page_without_browser
from processes import PENDULUM, ServerProcess, server, wait_until

import simx_client as v
from simx_client import Client
from simx_client.errors import NoSuchSignal
from simx_server.viewer.messages import Look, Survey
from simx_server.viewer.page.link import Eye, Hands
from simx_server.viewer.page.mirror import Copy, Mirror
from simx_server.viewer.page.panels.signals import Signals

pytestmark = pytest.mark.slow

IN_TIME = 20.0


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    scene = tmp_path_factory.mktemp("scene") / "pendulum.xml"
    scene.write_text(PENDULUM)
    with server(scene) as process:
        yield process


@pytest.fixture
def client(running: ServerProcess) -> Iterator[Client]:
    with Client(f"127.0.0.1:{running.port}") as client:
        yield client
        v.simxClearIntegerSignal(client.id, "", v.simx_opmode_blocking)
        v.simxClearFloatSignal(client.id, "", v.simx_opmode_blocking)
        v.simxClearStringSignal(client.id, "", v.simx_opmode_blocking)


class Tab:
    """The tab on a page, with hands that reach the server."""

    def __init__(self, elements: Elements, port: int) -> None:
        self.elements, self.problems = elements, Queue[str]()
        address = f"127.0.0.1:{port}"
        self.eye, self.mirror = Eye(address), Mirror()
        self.hands = Hands(address, self.problems.put)
        self.signals = Signals(elements.browser.gui, self.hands, self.mirror)

    def update(self) -> tuple[Survey, Look]:
        look = self.eye.look()
        self.mirror.update(look)
        survey = self.eye.survey()
        self.signals.update(survey, look)
        return survey, look

    def shows(self, text: str) -> bool:
        return wait_until(lambda: text in self.elements.texts(), IN_TIME, self.update)

    def type(self, name: str, kind: str, value: str) -> None:
        self.elements.one("text", "Name").value = name
        self.elements.one("dropdown", "Type").value = kind
        self.elements.one("text", "Value").value = value


@pytest.fixture
def tab(running: ServerProcess) -> Iterator[Tab]:
    with page_without_browser() as elements:
        tab = Tab(elements, running.port)
        yield tab
        tab.signals.close()
        tab.hands.close()
        tab.eye.close()


def test_signals_that_are_set_on_the_page_are_read_over_the_api(tab: Tab, client: Client) -> None:
    for name, kind, value in (
        ("count", "integer", "0x10"),
        ("gain", "float", "0.25"),
        ("word", "string", "häh?"),
    ):
        tab.type(name, kind, value)
        tab.elements.click("Set signal")
        assert tab.shows(name)
    assert client.signals.ints["count"] == 16
    assert client.signals.floats["gain"] == 0.25
    assert client.signals.strings["word"] == "häh?"
    tab.type("gain", "float", "")
    tab.elements.click("Clear signal")
    assert wait_until(lambda: "gain" not in tab.elements.texts(), IN_TIME, tab.update)
    with pytest.raises(NoSuchSignal):
        client.signals.floats["gain"]


@pytest.mark.parametrize(
    ("name", "kind", "value", "problem"),
    [
        ("a", "integer", "1.5", "'1.5' is no integer"),
        ("a", "integer", "4294967296", "more than 32 bits"),
        ("a", "float", "much", "'much' is no number"),
        ("", "string", "b", "needs a name"),
    ],
)
def test_what_cannot_be_set_is_told(tab: Tab, name: str, kind: str, value: str, problem: str) -> None:
    tab.type(name, kind, value)
    tab.elements.click("Set signal")
    assert problem in tab.problems.get(timeout=IN_TIME)


def test_a_signal_that_is_chosen_can_be_changed(tab: Tab, client: Client) -> None:
    client.signals.ints["count"] = 3
    assert tab.shows("count")
    tab.elements.one("dropdown", "Signal").value = "count (integer)"
    assert tab.elements.one("text", "Value").value == "3"
    tab.elements.one("text", "Value").value = "4"
    tab.elements.click("Set signal")
    assert wait_until(lambda: client.signals.ints["count"] == 4, IN_TIME)


def test_texts_of_clients_are_shown_and_not_obeyed(tab: Tab, client: Client) -> None:
    client.signals.strings["<img src=x onerror=alert(1)>"] = "a <b>bold</b> one"
    client.signals.buffers["packed"] = bytes(range(250, 256)) * 100
    client.signals.strings["long"] = "ä" * 200
    client.signals.ints["y" * 1000] = 1
    assert tab.shows("&lt;img src=x onerror=alert(1)&gt;")
    assert "a &lt;b&gt;bold&lt;/b&gt; one" in tab.elements.texts()
    assert "<img" not in tab.elements.texts()
    assert "y" * 299 + "…" in tab.elements.texts()
    assert "y" * 300 not in tab.elements.texts()
    assert "fa fb fc fd fe ff" in tab.elements.texts()
    assert "(600 bytes)" in tab.elements.texts()
    assert "ä" * 100 + " … (400 bytes)" in tab.elements.texts()


def test_streams_are_listed_with_who_armed_them(tab: Tab, client: Client) -> None:
    hinge = client.joint("hinge").handle
    v.simxGetJointPosition(client.id, hinge, v.simx_opmode_streaming)
    assert tab.shows("simxGetJointPosition")
    assert os.path.basename(sys.argv[0]) in tab.elements.texts()  # what this client is called
    v.simxGetJointPosition(client.id, hinge, v.simx_opmode_discontinue)
    assert wait_until(lambda: "simxGetJointPosition" not in tab.elements.texts(), IN_TIME, tab.update)


def test_nothing_is_sent_when_nothing_changed(tab: Tab, client: Client) -> None:
    client.signals.floats["gain"] = 0.5
    assert tab.shows("gain")
    tab.update()
    before = len(tab.elements.messages)
    tab.update()
    tab.update()
    assert len(tab.elements.messages) == before


# --- plots, of surveys that are written here ------------------------------------------------------


class Plotted:
    """A tab whose surveys the test makes: time goes as it says."""

    def __init__(self, tab: Tab) -> None:
        self._tab, self.elements = tab, tab.elements
        survey, self.look = tab.update()
        tab.eye.forget()
        self.tree = tab.eye.survey()["tree"]
        assert self.tree is not None
        self.survey = copy.deepcopy(survey)
        self.survey["tree"] = None

    def at(self, time: float, **floats: float) -> None:
        self.survey["signals"]["floats"] = floats
        self.look["time"] = time
        self._tab.signals.update(self.survey, self.look)

    def add(self, title: str) -> None:
        choice = self.elements.one("dropdown", "Of")
        assert title in choice.options
        choice.value = title
        self.elements.click("Add plot")

    def curves(self, number: int = 0) -> list[list[float]]:
        """Times, then values."""
        return [each.tolist() for each in self.elements.all("uplot")[number].data]


@pytest.fixture
def plotted(tab: Tab) -> Plotted:
    return Plotted(tab)


def test_a_plot_grows_with_time_and_begins_anew_with_it(plotted: Plotted) -> None:
    plotted.at(0.0, wave=1.0)
    plotted.add("float signal wave")
    plotted.at(0.1, wave=1.0)
    plotted.at(0.2, wave=2.0)
    plotted.at(0.2, wave=3.0)  # paused
    assert plotted.curves() == [[0.1, 0.2], [1.0, 2.0]]
    plotted.at(0.3)  # cleared
    plotted.at(0.4, wave=float("nan"))
    assert plotted.curves() == [[0.1, 0.2], [1.0, 2.0]]
    plotted.at(0.0, wave=7.0)  # stopped
    plotted.at(0.1, wave=8.0)
    assert plotted.curves() == [[0.0, 0.1], [7.0, 8.0]]


def test_a_plot_remembers_half_a_minute(plotted: Plotted) -> None:
    plotted.at(0.0, wave=0.0)
    plotted.add("float signal wave")
    for number in range(1, 500):
        plotted.at(number * 0.1, wave=0.0)
    times = plotted.curves()[0]
    assert times[0] == pytest.approx(19.9, abs=0.15)
    assert times[-1] == pytest.approx(49.9)


def test_joints_are_plotted_with_their_targets(plotted: Plotted) -> None:
    plotted.at(0.0)
    plotted.add("joint hinge / rad")
    (joint,) = plotted.survey["joints"].values()
    joint["position"], joint["target"] = 0.5, 0.75
    plotted.at(0.1)
    assert plotted.curves() == [[0.1], [0.5], [0.75]]
    (chart,) = plotted.elements.all("uplot")
    assert "range" not in chart.scales["y"]
    plotted.look["time"] = 0.0
    joint["target"] = 0.5
    plotted.at(0.05)  # begun anew, and at rest
    assert chart.scales["y"]["range"] == pytest.approx((0.4925, 0.5075))
    plotted.at(0.1)
    plotted.survey["joints"].clear()  # it has gone
    plotted.at(0.2)
    assert plotted.curves()[0] == [0.05, 0.1]


def test_the_selected_object_is_plotted_where_it_is(plotted: Plotted, tab: Tab) -> None:
    assert plotted.tree is not None
    plotted.look["selection"] = [item["handle"] for item in plotted.tree if item["name"] == "arm"]
    plotted.at(0.0)
    plotted.add("position of arm / m")
    plotted.look["selection"] = []  # what was chosen stays
    plotted.at(0.1)
    assert plotted.curves() == [[0.1], [0.0], [0.0], [1.0]]
    empty = mujoco.MjModel.from_xml_string("<mujoco/>")
    tab.mirror.copy = Copy(empty, mujoco.MjData(empty))
    plotted.at(0.2)
    assert plotted.curves()[0] == [0.1]


def test_there_are_four_plots_at_most_and_each_can_be_removed(plotted: Plotted) -> None:
    plotted.at(0.0, wave=1.0)
    for _ in range(5):
        plotted.add("float signal wave")
    plotted.at(0.1, wave=1.0)
    charts: list[Any] = plotted.elements.all("uplot")
    assert len(charts) == 4
    assert plotted.elements.one("button", "Add plot").disabled
    plotted.elements.click("Remove plot")
    plotted.at(0.2, wave=1.0)
    assert plotted.elements.all("uplot") == charts[:3]
    assert not plotted.elements.one("button", "Add plot").disabled
    assert np.all(np.array(plotted.curves(2)) == [[0.1, 0.2], [1.0, 1.0]])
