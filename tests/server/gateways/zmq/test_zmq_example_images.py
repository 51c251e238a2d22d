"""A program like the official example synchronousImageTransmission: an image goes to the program and back."""

from __future__ import annotations

from pathlib import Path

import pytest
from zmq_examples import SCENE
from zmq_world import zmq_world

pytestmark = pytest.mark.gl


def test_images_go_to_the_program_and_back_in_step_with_the_simulation(tmp_path: Path) -> None:
    with zmq_world(tmp_path, scene=SCENE) as server:
        sim = server.sim()
        eye, screen = sim.getObject("/VisionSensor"), sim.getObject("/PassiveVisionSensor")
        sim.setStepping(True)
        sim.startSimulation()
        sim.step()
        image, resolution = sim.getVisionSensorImg(eye)
        assert (resolution, len(image)) == ([16, 8], 16 * 8 * 3)
        assert len(set(image)) > 1, "it shows the floor"
        inverted = bytes(255 - each for each in image)
        sim.setVisionSensorImg(screen, inverted)
        sim.step()
        assert list(sim.getVisionSensorImg(screen)) == [inverted, [16, 8]]
        old_form, width, height = sim.getVisionSensorCharImage(eye)
        assert (len(old_form), width, height) == (len(image), 16, 8)
        sim.setVisionSensorCharImage(screen, old_form)
        assert sim.getVisionSensorCharImage(screen)[0] == old_form
        sim.stopSimulation()
