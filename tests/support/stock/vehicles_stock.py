"""V-REP's stock quadricopter and cars: every object of their tables, in world axes, at x = y = 0."""

from __future__ import annotations

from model_checks import CAMERA, DUMMY, FORCE, PRISMATIC, REVOLUTE, SHAPE, Stock, Vector

FULL_TURN = 6.28
UP: Vector = (0.0, 0.0, 1.0)
_ROTORS = {1: (0.0919, 0.0919), 2: (-0.0919, 0.0919), 3: (-0.0919, -0.0919), 4: (0.0919, -0.0919)}

QUADRICOPTER = (
    Stock("Quadricopter", SHAPE, (0, 0, 0.51), euler_deg=(0, 0, 0), mass=0.12),
    *(Stock(f"Quadricopter_propeller{i}", FORCE, (x, y, 0.5), UP) for i, (x, y) in _ROTORS.items()),
    *(
        Stock(f"Quadricopter_propeller_respondable{i}", SHAPE, (x, y, 0.512), mass=0.1)
        for i, (x, y) in _ROTORS.items()
    ),
    *(
        Stock(
            f"Quadricopter_propeller_joint{i}", REVOLUTE, (x, y, 0.5), UP,
            interval="cyclic", mode=0, position_q=0, max_force=0.1562, upper_velocity=FULL_TURN,
        )
        for i, (x, y) in _ROTORS.items()
    ),
    Stock("Quadricopter_floorCamera", CAMERA, (0, 0, 0.5), (0, 0, -1)),
    Stock("Quadricopter_frontCamera", CAMERA, (0.13, 0, 0.51), (1, 0, 0)),
    Stock("Quadricopter_base", DUMMY, (0, 0, 0.5)),
    Stock("Quadricopter_target", SHAPE, (0, 0, 0.5)),
)  # fmt: skip


def _joint(
    name: str, place: Vector, axis: Vector, max_force: float, upper: float = FULL_TURN, kind: str = REVOLUTE
) -> Stock:
    interval = (-0.5, 0.5) if kind == PRISMATIC else "cyclic"
    return Stock(
        name, kind, place, axis,
        interval=interval, mode=5, position_q=0, max_force=max_force, upper_velocity=upper,
    )  # fmt: skip


def _spring(name: str, x: float, y: float) -> Stock:
    return _joint(f"nakedCar_{name}SpringDamper", (x, y, 0.6893), UP, 2e4, 10, PRISMATIC)


_RIGHT, _LEFT, _FRONT, _REAR = -0.7554, 0.755, -1.2884, 1.2888
_X: Vector = (1.0, 0.0, 0.0)

ACKERMANN = (
    Stock("nakedAckermannSteeringCar", SHAPE, (0, 0, 0.4377), euler_deg=(90.4, 0, 90), mass=600),
    _spring("rearRight", _RIGHT, _REAR),
    _joint("nakedCar_freeAxisRight", (_RIGHT, _REAR, 0.4893), _X, 200),
    Stock("nakedCar_rearRightWheel_respondable", SHAPE, (_RIGHT, _REAR, 0.4893), mass=10),
    _spring("rearLeft", _LEFT, _REAR),
    _joint("nakedCar_freeAxisLeft", (_LEFT, _REAR, 0.4893), _X, 200),
    Stock("nakedCar_rearLeftWheel_respondable", SHAPE, (_LEFT, _REAR, 0.4893), mass=10),
    _spring("frontLeft", _RIGHT, _FRONT),
    _joint("nakedCar_steeringRight", (_RIGHT, _FRONT, 0.5893), UP, 1e4),
    _joint("nakedCar_motorRight", (_RIGHT, _FRONT, 0.4893), _X, 200),
    Stock("nakedCar_frontRightWheel_respondable", SHAPE, (_RIGHT, _FRONT, 0.4893), mass=7),
    Stock("nakedCar_lineSegmentFrontRight", DUMMY, (_RIGHT, _FRONT, 0.4893)),
    _spring("frontRight", _LEFT, _FRONT),
    _joint("nakedCar_steeringLeft", (_LEFT, _FRONT, 0.5893), UP, 1e4),
    _joint("nakedCar_motorLeft", (_LEFT, _FRONT, 0.4893), _X, 200),
    Stock("nakedCar_frontLeftWheel_respondable", SHAPE, (_LEFT, _FRONT, 0.4893), mass=7),
    Stock("nakedCar_lineSegmentFrontLeft", DUMMY, (_LEFT, _FRONT, 0.4893)),
    Stock("nakedCar_lineSegmentRear", DUMMY, (0, _REAR, 0.4893)),
    Stock("AutoFittingCamera", CAMERA, (4.275, 3.5206, 0.1), (-0.48, 0.819, -0.313)),
)


def _brake(name: str, x: float, y: float) -> Stock:
    return _joint(f"{name}_brake_joint", (x, y, 0.2032), (-1, 0, 0), 0)


def _steered(name: str, x: float, max_force: float) -> Stock:
    return Stock(
        name, REVOLUTE, (x, 0.3247, 0.2032), UP,
        interval=(-3.142, 3.142), mode=5, position_q=0, max_force=max_force, upper_velocity=FULL_TURN,
    )  # fmt: skip


MANTA = (
    Stock("Manta", SHAPE, (0, 0, 0.3258), euler_deg=(0, 0, 0)),
    Stock("body_dummy", DUMMY, (0, 0.0247, 0.1632)),
    _joint("steer_joint", (0, 0.3247, 0.2332), UP, 1000, 1.22),
    _joint("motor_joint", (0, -0.2753, 0.2332), (-1, 0, 0), 60),
    _brake("bl", -0.175, -0.2753),
    _brake("br", 0.175, -0.2753),
    _steered("fl_steer", -0.175, 200.5),
    _brake("fl", -0.175, 0.3247),
    _steered("fr_steer", 0.175, 2.5),
    _brake("fr", 0.175, 0.3247),
)
