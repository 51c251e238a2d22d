"""Stock arms and grippers are as V-REP has them, and hold still."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from arm_stock import MODELS, SCENES
from model_checks import check_copies, check_idle, check_stock, real_time_factor
from real_world import Open, start_stepped

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("file", MODELS)
def test_model_and_its_copy_are_vreps_and_stand_still(world: Open, file: str) -> None:
    opened, client = world("stock_kinect")
    rows = MODELS[file]
    check_copies(opened, client, file, rows)
    start_stepped(client)
    # RG2 opens when the simulation starts.
    check_idle(client, [row.name + suffix for row in rows for suffix in ("", "#0")], 8.0, 3.0)


@pytest.mark.parametrize("scene", SCENES)
def test_scene_stands_still_for_a_minute(
    world: Open, scene: str, record_property: Callable[[str, str], None]
) -> None:
    opened, client = world(scene)
    check_stock(opened, client, SCENES[scene])
    start_stepped(client)
    check_idle(client, [row.name for row in SCENES[scene]])
    factor = real_time_factor(opened, 3.0)
    record_property("figures", f"{scene}: {factor:.0f} times real time")
