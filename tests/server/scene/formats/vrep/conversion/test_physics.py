"""Steps and gravity of an imported scene."""

from __future__ import annotations

import math

import pytest
from vrep_shapes import converted, file_of

from simx_server.scene.formats.annotations import read_annotations
from simx_server.scene.formats.vrep.conversion.physics import LONGEST, physics_step, set_physics
from simx_server.scene.formats.vrep.objects import Settings


@pytest.mark.parametrize(
    ("wanted", "simulation", "expected"),
    [
        (0.005, 0.05, 0.005),
        (0.02, 0.05, 0.005),
        (0.001, 0.05, 0.001),
        (0.002, 0.005, 0.005 / 3),
        (0.005, 0.001, 0.001),
    ],
)
def test_physics_step_is_a_part_of_the_simulation_step(
    wanted: float, simulation: float, expected: float
) -> None:
    assert physics_step(wanted, simulation) == pytest.approx(expected)


@pytest.mark.parametrize("wanted", [0.0, -1.0, math.nan, math.inf, 1e-12])
def test_physics_step_of_a_damaged_file_is_usable(wanted: float) -> None:
    step = physics_step(wanted, 0.05)
    assert 0.0001 < step <= LONGEST
    assert round(0.05 / step) == pytest.approx(0.05 / step)


def test_settings_of_the_file_arrive() -> None:
    settings = Settings(time_step=0.02, physics_step=0.004, gravity=(0.0, 1.0, -1.62))
    conversion = converted(file_of(settings=settings))
    set_physics(conversion)
    model = conversion.spec.compile()
    assert model.opt.gravity.tolist() == [0.0, 1.0, -1.62]
    assert model.opt.timestep == pytest.approx(0.004)
    assert read_annotations(conversion.spec).time_step == 0.02


def test_settings_that_are_no_numbers_are_the_usual_ones() -> None:
    settings = Settings(time_step=math.nan, gravity=(0.0, math.inf, math.nan))
    conversion = converted(file_of(settings=settings))
    set_physics(conversion)
    assert conversion.spec.compile().opt.gravity.tolist() == [0.0, 0.0, -9.81]
    assert read_annotations(conversion.spec).time_step == 0.05
