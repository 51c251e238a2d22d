"""V-REP's stock e-puck: every object, in world axes, with the robot standing at x = y = 0."""

from __future__ import annotations

from model_checks import CONE, DUMMY, FORCE, REVOLUTE, SHAPE, VISION, Stock, Vector

_UP: Vector = (0, 0, 1)


def _motor(side: str, x: float) -> tuple[Stock, ...]:
    return (
        Stock(
            f"ePuck_{side}Joint", REVOLUTE, (x, 0, 0.0212), (-1, 0, 0), interval="cyclic", mode=5,
            position_q=0, max_force=2.5, upper_velocity=6.28,
        ),
        Stock(f"ePuck_{side}RespondableWheel", SHAPE, (x, 0, 0.0212), mass=0.02),
    )  # fmt: skip


def _slider(end: str, y: float) -> tuple[Stock, ...]:
    return (
        Stock(f"ePuck_{end}BodySliderLink", FORCE, (0, y, 0.005), _UP),
        Stock(f"ePuck_{end}RespondableSlider", SHAPE, (0, y, 0.005), mass=0.02),
    )


def _infrared(number: int, x: float, y: float, axis: Vector) -> Stock:
    return Stock(
        f"ePuck_proxSensor{number}", CONE, (x, y, 0.0331), axis, reach=0.04, offset=0, angle_deg=30,
        explicit=False,
    )  # fmt: skip


E_PUCK = (
    Stock("ePuck", SHAPE, (0, 0, 0.0191), euler_deg=(-90, 0, -90), mass=0.03),
    *_motor("right", 0.027),
    *_motor("left", -0.027),
    *_slider("front", 0.03),
    *_slider("rear", -0.03),
    _infrared(1, -0.0349, 0.0009, (-1, 0, 0)),
    _infrared(2, -0.027, 0.0227, (-0.707, 0.707, 0)),
    _infrared(3, -0.0096, 0.0337, (-0.259, 0.966, 0)),
    _infrared(4, 0.0094, 0.0337, (0.259, 0.966, 0)),
    _infrared(5, 0.027, 0.0227, (0.707, 0.707, 0)),
    _infrared(6, 0.0348, 0.0009, (1, 0, 0)),
    _infrared(7, 0.0207, -0.028, (0.574, -0.819, 0)),
    _infrared(8, -0.0207, -0.028, (-0.574, -0.819, 0)),
    Stock(
        "ePuck_camera", VISION, (0, 0.0345, 0.0276), (0, 1, 0), up=_UP,
        resolution=(128, 128), angle_deg=45, near=0.01, far=5, explicit=False,
    ),
    Stock(
        "ePuck_lightSensor", VISION, (0, 0.0298, 0.0017), (0, 0, -1), up=(0, 1, 0),
        resolution=(16, 2), ortho=0.022, near=0.0006, far=0.02, explicit=False,
    ),
    Stock("ePuck_speaker", DUMMY, (0.0016, -0.012, 0.0485)),
    Stock("ePuck_link", FORCE, (0, 0, 0.043), _UP),
    Stock("ePuck_topPart", SHAPE, (0, 0, 0.039), mass=0.03),
    Stock("ePuck_base", DUMMY, (0, 0, 0)),
)  # fmt: skip
