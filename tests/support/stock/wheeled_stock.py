"""V-REP's stock wheeled robots: every object, in world axes, with the robot standing at x = y = 0."""

from __future__ import annotations

import math

from model_checks import CONE, DUMMY, FORCE, REVOLUTE, SHAPE, VISION, Stock, Vector

FULL_TURN = 6.28


def _sonar(number: int, x: float, y: float, z: float, bearing_deg: float) -> Stock:
    bearing = math.radians(bearing_deg)
    axis = (math.cos(bearing), math.sin(bearing), 0.0)
    name = f"Pioneer_p3dx_ultrasonicSensor{number}"
    return Stock(name, CONE, (x, y, z), axis, reach=1.0, offset=0.0, angle_deg=30, explicit=False)


def drive_joint(
    name: str,
    x: float,
    y: float,
    z: float,
    max_force: float,
    axis: Vector = (0.0, 1.0, 0.0),
    position: float = 0.0,
) -> Stock:
    """A motor that turns a wheel, or a caster's free joint."""
    return Stock(
        name, REVOLUTE, (x, y, z), axis, interval="cyclic", mode=5, position_q=position,
        max_force=max_force, upper_velocity=FULL_TURN,
    )  # fmt: skip


PIONEER = (
    Stock("Pioneer_p3dx", SHAPE, (0, 0, 0.1388), euler_deg=(0, 0, 0), mass=16),
    drive_joint("Pioneer_p3dx_rightMotor", 0.0445, -0.1655, 0.0975, 3),
    Stock("Pioneer_p3dx_rightWheel", SHAPE, (0.0445, -0.1655, 0.0975), mass=1.5),
    drive_joint("Pioneer_p3dx_leftMotor", 0.0445, 0.1655, 0.0975, 3),
    Stock("Pioneer_p3dx_leftWheel", SHAPE, (0.0445, 0.1655, 0.0975), mass=1.5),
    drive_joint("Pioneer_p3dx_caster_freeJoint1", -0.149, 0, 0.061, 11.99, (0, 0, 1)),
    drive_joint("Pioneer_p3dx_caster_freeJoint2", -0.1268, 0, 0.0299, 11.99, (0, -1, 0)),
    Stock("Pioneer_p3dx_caster_wheel", SHAPE, (-0.1268, 0, 0.0299), mass=0.25),
    _sonar(1, 0.1064, 0.1382, 0.2069, 90),
    _sonar(2, 0.1554, 0.125, 0.2069, 50),
    _sonar(3, 0.1906, 0.0831, 0.2069, 30),
    _sonar(4, 0.2092, 0.0273, 0.2069, 10),
    _sonar(5, 0.2092, -0.0273, 0.2069, -10),
    _sonar(6, 0.1905, -0.0785, 0.2069, -30),
    _sonar(7, 0.1555, -0.1202, 0.2069, -50),
    _sonar(8, 0.1064, -0.1381, 0.2069, -90),
    _sonar(9, -0.1103, -0.1382, 0.207, -90),
    _sonar(10, -0.1596, -0.1202, 0.207, -130),
    _sonar(11, -0.1946, -0.0785, 0.207, -150),
    _sonar(12, -0.2132, -0.0273, 0.207, -170),
    _sonar(13, -0.2132, 0.0273, 0.207, 170),
    _sonar(14, -0.1946, 0.0785, 0.207, 150),
    _sonar(15, -0.1596, 0.1203, 0.207, 130),
    _sonar(16, -0.1103, 0.1382, 0.207, 90),
    *(
        Stock(f"Pioneer_p3dx_connection{number}", FORCE, (x, y, z), (0, 0, 1))
        for number, x, y, z in (
            (1, 0.0445, 0, 0.2371),
            (2, 0.0445, 0.13, 0.2371),
            (3, 0.1364, 0.0919, 0.2371),
            (4, 0.1645, 0, 0.2371),
            (5, 0.1364, -0.0919, 0.2371),
            (6, 0.0445, -0.13, 0.2371),
            (7, -0.0455, 0, 0.2371),
            (8, -0.1374, -0.105, 0.2371),
            (9, -0.1655, 0, 0.2371),
            (10, -0.1374, 0.105, 0.2371),
            (11, 0.2195, 0, 0.0677),
        )
    ),
)


def _bubble_rob(base: str, names: tuple[str, ...], angle_deg: float, offset: float) -> tuple[Stock, ...]:
    nose, left_motor, left_wheel, right_motor, right_wheel, link, caster = (base + name for name in names)
    return (
        Stock(base, SHAPE, (0, 0, 0.12), euler_deg=(0, 0, 0), mass=4.19),
        Stock(nose, CONE, (0.1, 0, 0.12), (1, 0, 0), reach=0.15, offset=offset, angle_deg=angle_deg),
        drive_joint(left_motor, 0.05, 0.1, 0.04, 2.5),
        Stock(left_wheel, SHAPE, (0.05, 0.1, 0.04), mass=0.804),
        drive_joint(right_motor, 0.05, -0.1, 0.04, 2.5),
        Stock(right_wheel, SHAPE, (0.05, -0.1, 0.04), mass=0.804),
        Stock(link, FORCE, (-0.07, 0, 0.05), (0, 0, 1)),
        Stock(caster, SHAPE, (-0.07, 0, 0.025), mass=0.524),
    )


REMOTE_BUBBLE_ROB = _bubble_rob(
    "remoteApiControlledBubbleRob",
    ("SensingNose", "LeftMotor", "LeftWheel", "RightMotor", "RightWheel", "Link", "Caster"),
    angle_deg=60,
    offset=0.0,
)
BUBBLE_ROB = _bubble_rob(
    "bubbleRob",
    ("_sensingNose", "_leftMotor", "_leftWheel", "_rightMotor", "_rightWheel", "_connection", "_slider"),
    angle_deg=30,
    offset=0.005,
)


def _line_sensor(name: str, y: float) -> Stock:
    return Stock(
        name, VISION, (0.0842, y, 0.0181), (0, 0, -1), up=(1, 0, 0),
        resolution=(16, 16), ortho=0.01, near=0.01, far=0.06, explicit=False,
    )  # fmt: skip


def _shown_wheel(name: str, x: float, y: float) -> Stock:
    return Stock(
        name, REVOLUTE, (x, y, 0.027), (0, 1, 0), interval="cyclic", mode=2,
        max_force=1000, upper_velocity=FULL_TURN,
    )  # fmt: skip


LINE_TRACER = (
    Stock("LineTracer", SHAPE, (0, 0, 0.0275), euler_deg=(180, -90, 180), mass=0.204),
    _line_sensor("LeftSensor", 0.0225),
    _line_sensor("RightSensor", -0.0225),
    _line_sensor("MiddleSensor", 0.0),
    drive_joint("DynamicLeftJoint", -0.0442, 0.0581, 0.027, 50, position=math.pi),
    Stock("DynamicLeftWheel", SHAPE, (-0.0442, 0.0581, 0.027), mass=0.08),
    _shown_wheel("LeftJoint", -0.0442, 0.0581),
    drive_joint("DynamicRightJoint", -0.0443, -0.0581, 0.027, 50, position=math.pi),
    Stock("DynamicRightWheel", SHAPE, (-0.0443, -0.0581, 0.027), mass=0.08),
    _shown_wheel("RightJoint", -0.0443, -0.0581),
    Stock("Force_sensor", FORCE, (0.0382, 0, 0.0133), (0, 0, 1)),
    Stock("DynamicSlider", SHAPE, (0.0385, 0.0005, 0.0065), mass=0.05),
    Stock("LineTracerBase", DUMMY, (-0.0442, 0, 0)),
)
