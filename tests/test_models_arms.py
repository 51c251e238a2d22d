"""Stock arms and their grippers are as V-REP has them, hold still, and go where scripts send them."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import arm_stock
import pytest
from model_checks import check_stock, load_model
from real_world import RealWorld

World = tuple[RealWorld, int]


@pytest.fixture
def world() -> Iterator[Callable[[str], World]]:
    """Opens a scene: the world, and a client of it."""
    opened: list[RealWorld] = []

    def open_scene(scene: str) -> World:
        opened.append(RealWorld(scene))
        return opened[-1], opened[-1].client()

    yield open_scene
    for each in opened:
        each.close()


MODELS = {
    "models/robots/non-mobile/UR3.ttm": arm_stock.UR3,
    "UR5.ttm": arm_stock.UR5,
    "UR10.ttm": arm_stock.UR10,
    "KUKA LBR iiwa 7 R800.ttm": arm_stock.LBR_IIWA_7,
    "KUKA LBR iiwa 14 R820.ttm": arm_stock.LBR_IIWA_14,
    "KUKA LBR4+.ttm": arm_stock.LBR4P,
    "Jaco arm.ttm": arm_stock.JACO,
    "Mico arm.ttm": arm_stock.MICO,
    "RG2.ttm": arm_stock.RG2,
}


@pytest.mark.parametrize("file", MODELS)
def test_model_and_its_copy_are_vreps(world: Callable[[str], World], file: str) -> None:
    opened, client = world("stock_kinect")
    rows = MODELS[file]
    load_model(client, file, (0.0, 0.0))
    load_model(client, file, (1.0, 1.5))
    check_stock(opened, client, rows)
    check_stock(opened, client, rows, suffix="#0", shift=(1.0, 1.5, 0.0))
