"""Joints without a motor: they rest where they are almost balanced, and move freely elsewhere."""

from __future__ import annotations

import math

import pytest
from handler_calls import QuickPainter, World
from vrep_writer import VrepWriter

from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert
from simx_server.scene.formats.vrep.reading import read_file

LEVEL = math.pi / 2


def drawer(slope: float) -> float:
    """Return how far a drawer slides in a second on a slope in rad."""
    writer = VrepWriter(25)
    half = (LEVEL + slope) / 2
    frame = writer.shape("frame", cuboid=(0.5, 0.5, 0.5), position=(0, 0, 1))
    joint = writer.joint(
        "rail", parent=frame, kind="prismatic", motor=False, limits=(0.0, 1.0),
        quaternion=(0.0, math.sin(half), 0.0, math.cos(half)),
    )  # fmt: skip
    writer.shape("drawer", parent=joint, cuboid=(0.2, 0.2, 0.1), dynamic=True, mass=0.4)
    writer.settings(time_step=0.05)
    spec, _ = convert(read_file(writer.bytes(), "scene.ttt"))
    world = World(painter=QuickPainter())
    world.sim.use(*build(spec, None))
    world.run(20)
    position: float = world.call("simxGetJointPosition", world.handle("rail"))
    return position


def test_a_drawer_that_is_almost_level_stays_shut() -> None:
    assert drawer(0.0005) == pytest.approx(0.0, abs=1e-5)


def test_a_drawer_slides_down_a_slope() -> None:
    assert drawer(0.1) == pytest.approx(0.5 * 9.81 * math.sin(0.1), rel=0.05)
