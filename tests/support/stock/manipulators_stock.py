"""V-REP's stock youBot: every object, in world axes, with the robot standing at x = y = 0."""

from __future__ import annotations

from model_checks import DUMMY, PRISMATIC, REVOLUTE, SHAPE, Stock, Vector

_X: Vector = (1.0, 0.0, 0.0)
FORCE_MODE, IK_MODE, PASSIVE_MODE = 5, 2, 0


def _wheel(corner: str, x: float, y: float, slip: Vector) -> tuple[Stock, ...]:
    return tuple(
        Stock(
            f"{kind}Joint_{corner}", REVOLUTE, (x, y, 0.0504), axis, interval="cyclic", mode=FORCE_MODE,
            position_q=0, max_force=2.5, upper_velocity=6.28,
        )
        for kind, axis in (("rolling", _X), ("slipping", slip))
    )  # fmt: skip


def _arm(
    number: int, place: Vector, axis: Vector, interval: tuple[float, float], q: float, mode: int = IK_MODE
) -> Stock:
    return Stock(
        f"youBotArmJoint{number}", REVOLUTE, place, axis, interval=interval, mode=mode, position_q=q,
        max_force=100, upper_velocity=6.28,
    )  # fmt: skip


def _finger(number: int, x: float, interval: tuple[float, float], q: float) -> Stock:
    return Stock(
        f"youBotGripperJoint{number}", PRISMATIC, (x, -0.0936, 0.2177), _X, interval=interval,
        mode=FORCE_MODE, position_q=q, max_force=300, upper_velocity=10,
    )  # fmt: skip


YOUBOT = (
    Stock("youBot", SHAPE, (0, 0, 0.0957), euler_deg=(-90, 0.1, -90), mass=10),
    *_wheel("rr", 0.1585, -0.228, (0.707, 0.707, 0)),
    *_wheel("rl", -0.1586, -0.228, (0.707, -0.707, 0)),
    Stock(
        "Joint", REVOLUTE, (-0.0001, 0.228, 0.0504), (0, -1, 0), interval=(-0.175, 0.175), mode=FORCE_MODE,
        position_q=0, max_force=2.5, upper_velocity=6.28,
    ),
    *_wheel("fl", -0.1586, 0.228, (0.707, 0.707, 0)),
    *_wheel("fr", 0.1585, 0.228, (0.707, -0.707, 0)),
    _arm(0, (-0.0001, 0.1662, 0.1447), (0, 0, 1), (-2.95, 2.95), 0.000141),
    _arm(1, (0.0393, 0.1992, 0.2459), _X, (-1.571, 1.309), 0.5395),
    _arm(2, (0.0304, 0.1195, 0.3788), _X, (-2.286, 2.286), 0.9149),
    Stock("youBot_orientationBase", DUMMY, (-0.0011, -0.0145, 0.3944)),
    _arm(3, (-0.0196, -0.0145, 0.3944), _X, (-1.78, 1.78), 1.269),
    _arm(4, (-0.0006, -0.0541, 0.3067), (0, -0.407, -0.914), (-1.571, 1.571), -9.892e-05, PASSIVE_MODE),
    _finger(1, -0.0011, (0, 0.025), 0.025),
    _finger(2, 0.0239, (-0.05, 0), -0.05),
    Stock("youBot_positionTip", DUMMY, (-0.0011, -0.0936, 0.2177)),
    Stock("youBot_ref", DUMMY, (-0.0001, 0, 0)),
    Stock("youBot_positionTarget", DUMMY, (-0.0011, -0.0936, 0.2177)),
)  # fmt: skip
