"""V-REP's fast laser scanner, as the stock model has it."""

from __future__ import annotations

import math

from model_checks import DUMMY, REVOLUTE, SHAPE, VISION, Stock

NEAR, FAR = 0.009, 5.0


def _half(number: int, turn: float) -> tuple[Stock, Stock]:
    place = (0.0, 0.0, 0.063)
    return (
        Stock(
            f"fastHokuyo_joint{number}", REVOLUTE, place, (0, 0, 1),
            interval="cyclic", mode=5, position_q=turn, max_force=2.5, upper_velocity=6.28,
        ),
        Stock(
            f"fastHokuyo_sensor{number}", VISION, place, (math.cos(turn), math.sin(turn), 0), up=(0, 0, 1),
            resolution=(256, 1), angle_deg=120, near=NEAR, far=FAR,
        ),
    )  # fmt: skip


SCANNER = (
    Stock("fastHokuyo", SHAPE, (0, 0, 0.035), euler_deg=(0, 0, 0), mass=0.2),
    *_half(1, -math.pi / 3),
    *_half(2, math.pi / 3),
    Stock("fastHokuyo_ref", DUMMY, (0, 0, 0)),
)
