"""V-REP's stock small wheeled robots, as in `wheeled_stock.py`; only what the stock tables name."""

from __future__ import annotations

from model_checks import CAMERA, CONE, FORCE, PRISMATIC, RAY, SHAPE, VISION, Stock, Vector
from wheeled_stock import drive_joint

_AHEAD_MINUS_Y: Vector = (1.0, 0.0, 0.0)
_AHEAD_PLUS_Y: Vector = (-1.0, 0.0, 0.0)
_UP: Vector = (0.0, 0.0, 1.0)
_DOWN: Vector = (0.0, 0.0, -1.0)

DR12 = (
    Stock("dr12", SHAPE, (0, 0, 0.0787), euler_deg=(3.4, -89.8, 3.5), mass=5),
    drive_joint("dr12_leftJoint_", 0.0179, 0.077, 0.0449, 1),
    Stock("dr12_respondableLeftWheel_", SHAPE, (0.0179, 0.0815, 0.0449), mass=0.5),
    drive_joint("dr12_rightJoint_", 0.0179, -0.0771, 0.0449, 1),
    Stock("dr12_respondableRightWheel_", SHAPE, (0.0179, -0.0815, 0.0449), mass=0.5),
    Stock("Camera1", CAMERA, (-0.0383, 0.0027, 0.1782), (0.966, -0.016, -0.256)),
    Stock("dr12_bumperForceSensor_", FORCE, (0.1169, 0, 0.0439), (1, 0, 0)),
    Stock("dr12_respondableBumper_", SHAPE, mass=0.5),
    Stock("dr12_sliderConnection_", FORCE, (-0.0961, 0, 0.0156), _UP),
    Stock("dr12_respondableSlider_", SHAPE, (-0.0961, 0, 0.0075), mass=0.2),
)

LUMIBOT = (
    Stock("lumibot", SHAPE, (0, 0, 0.025), euler_deg=(0, 0, 0)),
    Stock("lumibot_floorSensor", RAY, (0, 0.01, 0.0035), _DOWN, reach=0.005, offset=0.0),
    Stock(
        "lumibot_lightSensorAdjustment", PRISMATIC, (0, -0.0502, 0.007), (1, 0, 0),
        interval=(-0.5, 0.5), position_q=0.0, mode=2, max_force=50, upper_velocity=10,
    ),
    Stock(
        "lumibot_lightSensor", VISION, (0, -0.0502, 0.0087), _DOWN, up=(0, 1, 0),
        resolution=(16, 2), ortho=0.022, near=0.0006, far=0.02,
    ),
    drive_joint("lumibot_leftMotor", 0.0443, 0, 0.025, 20, _AHEAD_MINUS_Y),
    drive_joint("lumibot_rightMotor", -0.0443, 0, 0.025, 20, _AHEAD_MINUS_Y),
    Stock("lumibot_sliderLink", FORCE, (0, 0.04, 0.007), _UP),
    Stock("lumibot_bumpSensor", FORCE, (0, 0, 0.022), _UP),
)  # fmt: skip


def _near(name: str, position: Vector, axis: Vector) -> Stock:
    return Stock(name, CONE, position, axis, reach=0.1, offset=0.0, angle_deg=15)


K_JUNIOR = (
    Stock("KJunior", SHAPE, (0, 0, 0.0208), euler_deg=(-90, -89.9, -90)),
    Stock("KJunior_sliderLink1", FORCE, (0, -0.0445, 0.0072), _UP),
    Stock("KJunior_sliderLink2", FORCE, (0, 0.0436, 0.0072), _UP),
    drive_joint("KJunior_motorLeft", 0.0498, -0.0004, 0.0156, 2.5, _AHEAD_MINUS_Y),
    drive_joint("KJunior_motorRight", -0.0498, -0.0004, 0.0156, 2.5, _AHEAD_MINUS_Y),
    _near("KJunior_proxSensor1", (0.0426, -0.0362, 0.0273), (0.766, -0.643, 0)),
    _near("KJunior_proxSensor2", (0.0235, -0.0508, 0.0273), (0.423, -0.906, 0)),
    _near("KJunior_proxSensor3", (0, -0.056, 0.0273), (0, -1, 0)),
    _near("KJunior_proxSensor4", (-0.0235, -0.0508, 0.0273), (-0.423, -0.906, 0)),
    _near("KJunior_proxSensor5", (-0.0426, -0.0362, 0.0273), (-0.766, -0.643, 0)),
    _near("KJunior_proxSensor6", (0, 0.0552, 0.0273), (0, 1, 0)),
    _near("KJunior_proxSensor7", (0.0477, -0.0213, 0.0165), (0.161, -0.066, -0.985)),
    _near("KJunior_proxSensor8", (0.0107, -0.0503, 0.0205), _DOWN),
    _near("KJunior_proxSensor9", (-0.0107, -0.0503, 0.0205), _DOWN),
    _near("KJunior_proxSensor10", (-0.0477, -0.0213, 0.0165), (-0.161, -0.066, -0.985)),
    Stock("KJunior_bumpLink", FORCE, (0, -0.0004, 0.0168), _UP),
)


def _sonar(number: int, x: float, y: float, axis: Vector) -> Stock:
    name = f"K3_ultrasonicSensor{number}"
    return Stock(name, CONE, (x, y, 0.0437), axis, reach=2.99, offset=0.0, angle_deg=60)


def _infrared(number: int, x: float, y: float, axis: Vector) -> Stock:
    return Stock(
        f"K3_infraredSensor{number}", CONE, (x, y, 0.0257), axis, reach=0.2, offset=0.0, angle_deg=13
    )


def _colour_sensor(name: str, position: Vector) -> Stock:
    return Stock(
        name, VISION, position, _DOWN, up=(-1, 0, 0), resolution=(8, 8), ortho=0.01, near=0.0075, far=0.04
    )


KHEPERA = (
    Stock("K3_robot", SHAPE, (0, 0, 0.0403), euler_deg=(90, -88.5, 90)),
    _sonar(1, -0.0605, -0.0028, (-1, 0, 0)),
    _sonar(2, -0.0453, 0.0367, (-0.643, 0.766, 0)),
    _sonar(3, 0, 0.0529, (0, 1, 0)),
    _sonar(4, 0.0453, 0.0367, (0.643, 0.766, 0)),
    _sonar(5, 0.0605, -0.0028, (1, 0, 0)),
    _infrared(1, -0.0619, 0.0081, (-0.985, 0.174, 0)),
    _infrared(2, -0.0446, 0.0417, (-0.707, 0.707, 0)),
    _infrared(3, -0.0154, 0.0584, (-0.242, 0.97, 0)),
    _infrared(4, 0.0154, 0.0584, (0.242, 0.97, 0)),
    _infrared(5, 0.0446, 0.0417, (0.707, 0.707, 0)),
    _infrared(6, 0.0619, 0.0081, (0.985, 0.174, 0)),
    _infrared(7, 0.0483, -0.0456, (0.643, -0.766, 0)),
    _infrared(8, 0, -0.0601, (0, -1, 0)),
    _infrared(9, -0.0483, -0.0456, (-0.643, -0.766, 0)),
    _colour_sensor("K3_colorSensorLeft", (-0.0099, 0.051, 0.014)),
    _colour_sensor("K3_colorSensorRight", (0.0099, 0.051, 0.0139)),
    drive_joint("K3_leftWheelMotor", -0.0429, -0.0078, 0.0209, 2.5, _AHEAD_PLUS_Y),
    drive_joint("K3_rightWheelMotor", 0.043, -0.0078, 0.0209, 2.5, _AHEAD_PLUS_Y),
    Stock("K3_casterBodyLink", FORCE, (0.0001, 0.0359, 0.0109), _UP),
    Stock("K3_baseExtensionLink", FORCE, (0, -0.008, 0.07), _UP),
)
