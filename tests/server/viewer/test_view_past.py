"""The time slider: which step is shown, what clients called in it, and a new run from it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import msgpack
import pytest
import viser
from browser_panels import Stage, browser
from real_world import BLOCKING, RealWorld, handle_of

import simx_client as v
from simx_client.protocol.add_ons.past import STEP, PastStep
from simx_server.history import History
from simx_server.simulation.simulation import SimulationState
from simx_server.viewer.messages import ADD_ON
from simx_server.viewer.page.panels.time_slider import TimeSlider, calls_as_html

pytestmark = pytest.mark.slow

__all__ = ["browser"]  # a fixture

SCENE = """
<mujoco>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 1 0 0" size="0.02"/>
    </body>
  </worldbody>
  <actuator><position joint="hinge" kp="10"/></actuator>
</mujoco>
"""


class Slider(Stage):
    """The time slider of a page, with a run of thirty steps behind it: a call before each tenth."""

    def __init__(self, world: RealWorld, client: int, browser: viser.ViserServer) -> None:
        self.history = History(world.loop.service, 60.0)
        world.loop.service.watchers.add(self.history)
        super().__init__(world, client, browser, self.history)
        self.told: list[tuple[str, str]] = []
        self.panel = self.time = TimeSlider(self.gui, self.hands, lambda *told: self.told.append(told))
        v.simxSynchronous(client, True)
        v.simxStartSimulation(client, BLOCKING)
        hinge = handle_of(client, "hinge")
        for step in range(30):
            if step % 10 == 9:
                v.simxSetJointTargetPosition(client, hinge, 0.1 * step, BLOCKING)
            v.simxGetJointPosition(client, hinge, BLOCKING)
            world.parts.step()
        self.show()

    @property
    def slider(self) -> Any:
        return self.labelled(viser.GuiSliderHandle, "Step")

    def press(self, button: str) -> None:
        group = self.labelled(viser.GuiButtonGroupHandle, "Past")
        self.set(group, button)
        self.follow()

    def follow(self) -> None:
        """The next action of the page."""
        for _ in range(2):  # the answer may turn to another step
            if (step := self.time.step) is not None:
                self.time.show(step, self.past(step))
        self.show()

    def past(self, step: int) -> PastStep:
        """The server's answer."""
        feed = self.world.parts.scripts.add_ons[ADD_ON]
        found: PastStep = msgpack.unpackb(feed.call(STEP, [step], [], [], b"")[3], strict_map_key=False)
        return found


@pytest.fixture
def slider(browser: viser.ViserServer, tmp_path: Path) -> Iterator[Slider]:
    scene = tmp_path / "arm.xml"
    scene.write_text(SCENE)
    world = RealWorld(scene)
    yield Slider(world, world.client(), browser)
    world.close()
    browser.gui.reset()


def test_it_spans_what_is_kept_and_stands_at_the_present(slider: Slider) -> None:
    assert (slider.slider.min, slider.slider.max, slider.slider.value) == (0, 30, 30)
    assert slider.time.step is None
    slider.world.parts.step()
    slider.show()
    assert (slider.slider.max, slider.slider.value) == (31, 31)
    assert "The past" not in slider.text()


def test_dragged_back_it_shows_the_step_and_stays_there(slider: Slider) -> None:
    slider.set(slider.slider, 12)
    slider.follow()
    assert slider.time.step == 12
    assert "The past: step 12, 0.60 s." in slider.text()
    assert "0.90 s ago; the simulation runs on" in slider.text()
    slider.world.parts.step()
    slider.follow()
    assert (slider.slider.value, slider.slider.max) == (12, 31)
    slider.set(slider.slider, 31)
    slider.follow()
    assert slider.time.step is None
    assert "The past" not in slider.text()


def test_buttons_go_by_steps_and_to_calls(slider: Slider) -> None:
    steps = []
    for button in ("◀", "◀", "▶", "◀ call", "◀ call", "call ▶", "first", "◀", "now"):
        slider.press(button)
        steps.append(slider.time.step)
    assert steps == [29, 28, 29, 20, 10, 20, 0, 0, None]
    slider.press("◀ call")
    assert slider.time.step == 20, "the last call before the present step"


def test_an_answer_to_an_earlier_question_turns_nothing_back(slider: Slider) -> None:
    slider.press("first")
    for answered in range(4):
        slider.set(slider.labelled(viser.GuiButtonGroupHandle, "Past"), "▶")
        slider.time.show(answered, slider.past(answered))
    assert slider.time.step == 4
    slider.follow()
    assert "The past: step 4, 0.20 s." in slider.text()


def test_calls_of_the_step_are_shown_and_those_that_read_on_request(slider: Slider) -> None:
    slider.set(slider.slider, 20)
    slider.follow()
    text = slider.text()
    assert "simxSetJointTargetPosition(jointHandle=" in text
    assert "targetPosition=1.9" in text
    assert "simxGetJointPosition" not in text
    assert "1 read or trigger." in text
    slider.set(slider.labelled(viser.GuiCheckboxHandle, "Reads and triggers"), True)
    slider.follow()
    assert "simxGetJointPosition(" in slider.text()
    slider.set(slider.slider, 5)
    slider.follow()
    assert "simxSetJointTargetPosition" not in slider.text()


def test_a_new_run_goes_on_from_the_step_and_the_page_is_at_the_present_again(slider: Slider) -> None:
    slider.set(slider.slider, 12)
    slider.follow()
    slider.click("Go on from here")
    slider.follow()
    sim = slider.world.simulation
    assert (sim.state, sim.step_count) == (SimulationState.PAUSED, 12)
    assert slider.time.step is None
    assert slider.slider.max == 12
    assert slider.told == [("A new run", "It is paused at step 12, 0.60 s. Press Start to go on.")]


def test_another_scene_brings_the_page_back_to_the_present(slider: Slider) -> None:
    slider.set(slider.slider, 12)
    slider.follow()
    slider.world.simulation.stop()
    slider.world.simulation.close()
    slider.show()
    assert slider.time.step is None
    assert slider.slider.disabled
    slider.press("◀")
    assert slider.time.step is None


def test_a_stop_shows_the_present(slider: Slider) -> None:
    slider.set(slider.slider, 12)
    slider.follow()
    slider.world.simulation.stop()
    slider.show()
    assert slider.time.step is None
    assert "The past" not in slider.text()
    slider.press("◀")
    assert slider.time.step == 29, "the run that has ended can still be looked at"


def test_a_step_that_slides_out_of_the_kept_time_becomes_the_first_one(slider: Slider) -> None:
    slider.set(slider.slider, 2)
    slider.follow()
    history = slider.history
    del history._moments[:5], history._calls[:5]
    slider.show()
    slider.follow()
    assert (slider.time.step, slider.slider.value, slider.slider.min) == (5, 5, 5)
    assert "The past: step 5" in slider.text()


def test_going_on_from_a_step_that_has_slid_out_starts_from_the_first_one(slider: Slider) -> None:
    slider.set(slider.slider, 2)
    slider.follow()
    history = slider.history
    del history._moments[:5], history._calls[:5]
    slider.click("Go on from here")
    assert slider.world.simulation.step_count == 5
    assert slider.told[0][1].startswith("Step 2 is not kept any more. It is paused at step 5")


def test_texts_of_clients_are_escaped() -> None:
    call = {
        "client": "<b>", "call": "simxSetStringSignal(signalName='<script>')", "results": "<i>", "has_failed": True,
        "only_reads": False,
    }  # fmt: skip
    past = cast(Any, {"calls": [call], "calls_left_out": 3})
    text = calls_as_html(past, with_reads=False)
    assert "<script>" not in text
    assert "<b>" not in text
    assert "<i>" not in text
    assert "3 further calls" in text


def test_what_the_page_shows_meanwhile_takes_no_drag_away(slider: Slider) -> None:
    slider.set(slider.slider, 12)
    slider.follow()
    for before in (12, None):
        # The browser's message is here, and the call-back that reads it comes a moment later.
        slider.slider._impl.value = 3
        if before is not None:
            slider.time.show(before, slider.past(before))
        slider.show()
        slider.set(slider.slider, slider.slider.value)
        slider.follow()
        assert slider.time.step == 3
        assert "The past: step 3, 0.15 s." in slider.text()
        slider.press("now")
