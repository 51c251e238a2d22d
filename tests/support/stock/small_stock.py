"""V-REP's stock e-puck and NAO: every object, in world axes, with the robot standing at x = y = 0."""

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


def _joint(
    name: str, place: Vector, axis: Vector, interval: tuple[float, float], position: float = 0.0
) -> Stock:
    return Stock(
        name, REVOLUTE, place, axis, interval=interval, mode=5, position_q=position, max_force=30,
        upper_velocity=3,
    )  # fmt: skip


def _leg(
    side: str, y: float, yaw_axis: Vector, hip_roll: tuple[float, float], hip_pitch: tuple[float, float],
    ankle_roll: tuple[float, float],
) -> tuple[Stock, ...]:  # fmt: skip
    hip, knee, ankle = ((-0.0026, y, z) for z in (0.2482, 0.1482, 0.0453))
    return (
        _joint(f"{side}HipYawPitch3", hip, yaw_axis, (-1.145, 0.741)),
        _joint(f"{side}HipRoll3", hip, _X, hip_roll),
        _joint(f"{side}HipPitch3", hip, _Y, hip_pitch),
        _joint(f"{side}KneePitch3", knee, _Y, (-0.092, 2.113)),
        _joint(f"{side}AnklePitch3", ankle, _Y, (-1.186, 0.923)),
        _joint(f"{side}AnkleRoll3", ankle, _X, ankle_roll),
    )


def _arm(
    side: str, places: tuple[Vector, Vector, Vector], roll: tuple[float, float],
    elbow: tuple[float, float], bent: float,
) -> tuple[Stock, ...]:  # fmt: skip
    shoulder, bend, wrist = places
    return (
        _joint(f"{side}ShoulderPitch3", shoulder, _Y, (-2.086, 2.086)),
        _joint(f"{side}ShoulderRoll3", shoulder, _UP, roll),
        _joint(f"{side}ElbowYaw3", bend, _X, (-2.086, 2.086)),
        _joint(f"{side}ElbowRoll3", bend, _UP, elbow, bent),
        _joint(f"{side}WristYaw3", wrist, (0.999, bent, 0), (-1.824, 1.824)),
    )


def _eye(name: str, place: Vector, axis: Vector, up: Vector) -> Stock:
    return Stock(
        name, VISION, place, axis, up=up, resolution=(640, 480), angle_deg=61, near=0.02, far=20,
        explicit=False,
    )  # fmt: skip


_X: Vector = (1, 0, 0)
_Y: Vector = (0, 1, 0)
_FEET = {
    "RFsrRR": (-0.0323, -0.0796),
    "RFsrFR": (0.0676, -0.0796),
    "RFsrRL": (-0.0329, -0.0306),
    "RFsrFL": (0.0676, -0.0266),
    "LFsrRR": (-0.0323, 0.0312),
    "LFsrFR": (0.0676, 0.0272),
    "LFsrRL": (-0.0329, 0.0802),
    "LFsrFL": (0.0676, 0.0802),
}

NAO = (
    Stock("NAO", SHAPE, (0, 0, 0.3518), euler_deg=(0, 0, 0)),
    *_leg("R", -0.0497, (0, 0.707, 0.707), (-0.738, 0.415), (-1.772, 0.433), (-0.786, 0.389)),
    *_leg("L", 0.0503, (0, 0.707, -0.707), (-0.379, 0.774), (-1.774, 0.431), (-0.389, 0.786)),
    *(Stock(f"NAO_{name}", FORCE, (x, y, 0.0076), _UP) for name, (x, y) in _FEET.items()),
    *_arm(
        "R", ((-0.0026, -0.0977, 0.4332), (0.1024, -0.1127, 0.4332), (0.1583, -0.1108, 0.4333)),
        (-1.327, 0.314), (0.035, 1.545), 0.0349,
    ),
    *_arm(
        "L", ((-0.0026, 0.0983, 0.4333), (0.1024, 0.1133, 0.4333), (0.1583, 0.1113, 0.4333)),
        (-0.314, 1.327), (-1.545, -0.035), -0.0349,
    ),
    _joint("HeadYaw", (-0.0026, 0.0003, 0.4544), _UP, (-2.086, 2.086)),
    _joint("HeadPitch", (-0.0026, 0.0003, 0.4544), _Y, (-0.672, 0.515)),
    _eye("NAO_vision1", (0.0527, 0, 0.5247), (1, 0, -0.021), (0.02, 0, 1)),
    _eye("NAO_vision2", (0.0447, 0, 0.4788), (0.756, 0, -0.655), (0.65, 0, 0.76)),
)  # fmt: skip
