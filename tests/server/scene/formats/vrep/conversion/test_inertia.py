"""Masses and moments of inertia, also those that no body can have."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from vrep_shapes import box_leaf, converted, file_of, shape_of

from simx_server.scene.formats.vrep.conversion.inertia import LEAST_MASS, physical
from simx_server.scene.poses.poses import about


def converted_body(**parts: Any) -> tuple[Any, Any]:
    conversion = converted(file_of(shape_of(box_leaf(), is_dynamic=True, **parts)))
    return conversion.spec.compile().body("shape1"), conversion.report


def test_moments_are_per_mass_about_the_centre_along_the_inertia_frames_axes() -> None:
    turn = about((0.0, 0.0, 1.0), 0.3)
    body, report = converted_body(mass=2.0, inertia=(0.1, 0.2, 0.25), inertia_frame=((0.1, 0.2, 0.3), turn))
    assert body.mass[0] == 2.0
    assert sorted(body.inertia) == pytest.approx([0.2, 0.4, 0.5])
    assert body.ipos == pytest.approx([0.1, 0.2, 0.3])
    assert not report.approximated
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, body.iquat)
    axes = matrix.reshape(3, 3)
    full = axes @ np.diag(body.inertia) @ axes.T
    expected = 0.2 * math.cos(0.3) ** 2 + 0.4 * math.sin(0.3) ** 2
    assert full[0, 0] == pytest.approx(expected)


def test_impossible_moments_are_raised_as_little_as_possible_and_reported() -> None:
    body, report = converted_body(mass=1.0, inertia=(0.224, 0.112, 0.024))
    assert sorted(body.inertia) == pytest.approx([0.068, 0.156, 0.224], rel=1e-4)
    assert list(report.approximated.values()) == [["shape1"]]


@pytest.mark.parametrize(
    "moments",
    [
        (0.0, 0.0, 0.0),
        (-1.0, 0.1, 0.1),
        (math.nan, 0.1, 0.1),
        (1e-12, 1e-12, 1e-12),
        (math.inf, 1.0, 1.0),
        (1e30, 1.0, 1.0),
    ],
)
def test_any_moments_become_those_of_a_body(moments: tuple[float, float, float]) -> None:
    found, is_changed = physical(moments)
    assert is_changed
    assert min(found) > 0
    assert 2 * max(found) <= sum(found) * (1 + 1e-9)
    body, _ = converted_body(mass=1.0, inertia=moments)
    assert (body.inertia > 0).all()


def test_possible_moments_stay_and_single_precision_is_no_fault() -> None:
    assert physical((0.1, 0.2, 0.25)) == ((0.1, 0.2, 0.25), False)
    found, is_changed = physical((0.1, 0.2, 0.30000001192092896))
    assert not is_changed
    assert sum(found) == pytest.approx(0.6, rel=1e-4)


@pytest.mark.parametrize("mass", [0.0, -1.0, math.nan, 1e-9])
def test_a_dynamic_shape_weighs_something(mass: float) -> None:
    body, report = converted_body(mass=mass, inertia=(0.1, 0.1, 0.1))
    assert body.mass[0] == pytest.approx(LEAST_MASS)
    assert list(report.approximated.values()) == [["shape1"]]


def test_frame_that_is_no_frame_is_the_shapes_own() -> None:
    for frame in (((math.nan, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)), ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))):
        body, report = converted_body(mass=1.0, inertia=(0.1, 0.1, 0.1), inertia_frame=frame)
        assert body.ipos == pytest.approx([0, 0, 0])
        assert len(report.approximated) == 1


@pytest.mark.parametrize("third", [0.3, 0.30000001, 0.31, 0.5])
def test_moments_stay_those_of_a_body_when_the_scene_is_written_as_text(third: float) -> None:
    for mass in (1.0, 0.377, 13.7):
        body: dict[str, Any] = {"mass": mass, "inertia": (0.1, 0.2, third)}
        spec = converted(file_of(shape_of(box_leaf(), is_dynamic=True, **body))).spec
        spec.compile()
        assert mujoco.MjSpec.from_string(spec.to_xml()).compile().nbody == 2
