"""V-REP's stock arms: every object, in world axes, with the arm standing at x = y = 0."""

from __future__ import annotations

from model_checks import DUMMY, FORCE, PRISMATIC, RAY, REVOLUTE, SHAPE, Stock, Vector

FORCE_MODE, IK_MODE = 5, 2


def _joint(
    name: str,
    position: Vector,
    axis: Vector,
    interval: tuple[float, float] | str,
    max_force: float,
    upper_velocity: float,
    *,
    at: float = 0.0,
    mode: int = FORCE_MODE,
) -> Stock:
    return Stock(
        name,
        REVOLUTE,
        position,
        axis,
        interval=interval,
        mode=mode,
        position_q=at,
        max_force=max_force,
        upper_velocity=upper_velocity,
    )


LBR_IIWA_7 = (
    Stock("LBR_iiwa_7_R800", SHAPE, (0, 0, 0.0787), euler_deg=(0.0, 0.0, 0.0)),
    _joint("LBR_iiwa_7_R800_joint1", (0.0044, 0.0001, 0.1525), (0, 0, 1), (-2.967, 2.967), 176, 1.92),
    _joint("LBR_iiwa_7_R800_joint2", (0.0044, 0.0001, 0.34), (0, 1, 0), (-2.094, 2.094), 176, 1.92),
    _joint("LBR_iiwa_7_R800_joint3", (0.0044, 0.0001, 0.5195), (0, 0, 1), (-2.967, 2.967), 100, 2.23),
    _joint("LBR_iiwa_7_R800_joint4", (0.0044, 0.0001, 0.74), (0, -1, 0), (-2.094, 2.094), 100, 2.23),
    _joint("LBR_iiwa_7_R800_joint5", (0.0044, 0.0001, 0.9192), (0, 0, 1), (-2.967, 2.967), 100, 3.56),
    _joint("LBR_iiwa_7_R800_joint6", (0.0044, -0.0651, 1.14), (0, 1, 0), (-2.094, 2.094), 38, 3.21),
    _joint("LBR_iiwa_7_R800_joint7", (0.0044, 0.0001, 1.2257), (0, 0, 1), (-3.054, 3.054), 38, 3.21),
    Stock("LBR_iiwa_7_R800_connection", FORCE, (0.0044, 0.0001, 1.251), (0, 0, 1)),
)
"""LBR iiwa 7 R800."""

LBR_IIWA_14 = (
    Stock("LBR_iiwa_14_R820", SHAPE, (0, 0, 0.0787), euler_deg=(0.0, 0.0, 0.0)),
    _joint("LBR_iiwa_14_R820_joint1", (0.0073, 0, 0.1525), (0, 0, 1), (-2.967, 2.967), 176, 1.92),
    _joint("LBR_iiwa_14_R820_joint2", (0.0073, 0, 0.36), (0, 1, 0), (-2.094, 2.094), 176, 1.92),
    _joint("LBR_iiwa_14_R820_joint3", (0.0073, 0, 0.581), (0, 0, 1), (-2.967, 2.967), 100, 2.23),
    _joint("LBR_iiwa_14_R820_joint4", (0.0073, 0, 0.78), (0, -1, 0), (-2.094, 2.094), 100, 2.23),
    _joint("LBR_iiwa_14_R820_joint5", (0.0073, 0, 0.9595), (0, 0, 1), (-2.967, 2.967), 100, 3.56),
    _joint("LBR_iiwa_14_R820_joint6", (0.0073, -0.0656, 1.18), (0, 1, 0), (-2.094, 2.094), 38, 3.21),
    _joint("LBR_iiwa_14_R820_joint7", (0.0073, 0, 1.2561), (0, 0, 1), (-3.054, 3.054), 38, 3.21),
    Stock("LBR_iiwa_14_R820_connection", FORCE, (0.0073, 0, 1.291), (0, 0, 1)),
)
"""LBR iiwa 14 R820."""

LBR4P = (
    Stock("LBR4p", SHAPE, (0, 0, 0.0595), euler_deg=(0.0, 0.0, 0.0)),
    _joint("LBR4p_joint1", (-0.0001, 0.0001, 0.1105), (0, 0, 1), (-2.967, 2.967), 176, 1.92),
    _joint("LBR4p_joint2", (-0.0001, 0.0001, 0.3105), (0, -1, 0), (-2.094, 2.094), 176, 1.92),
    _joint("LBR4p_joint3", (-0.0001, 0.0001, 0.5105), (0, 0, 1), (-2.967, 2.967), 100, 2.23),
    _joint("LBR4p_joint4", (-0.0001, 0.0001, 0.7105), (0, -1, 0), (-2.094, 2.094), 100, 2.23),
    _joint("LBR4p_joint5", (-0.0001, 0.0001, 0.9105), (0, 0, 1), (-2.967, 2.967), 100, 3.56),
    _joint("LBR4p_joint6", (-0.0001, 0.0001, 1.1005), (0, -1, 0), (-2.094, 2.094), 38, 3.21),
    _joint("LBR4p_joint7", (-0.0001, 0.0001, 1.168), (0, 0, 1), (-2.967, 2.967), 38, 3.21),
    Stock("LBR4p_connection", FORCE, (-0.0001, 0.0001, 1.1785), (0, 0, 1)),
)
"""LBR4+."""

JACO = (
    Stock("Jaco", SHAPE, (0, 0, 0.0784), euler_deg=(0.0, 0.0, 0.0)),
    _joint("Jaco_joint1", (0, 0, 0.1567), (0, 0, -1), (-174.533, 174.533), 26, 0.628, at=3.142),
    _joint("Jaco_joint2", (0, 0, 0.2755), (0, 1, 0), (0.820, 5.463), 26, 0.628, at=3.142),
    _joint("Jaco_joint3", (0, 0, 0.6855), (0, -1, 0), (0.332, 5.952), 26, 0.628, at=3.142),
    _joint("Jaco_joint4", (0, 0.0098, 0.8928), (0, 0, -1), (-174.533, 174.533), 7, 0.838, at=3.142),
    _joint("Jaco_joint5", (0, 0.044, 0.9586), (0, -0.819, -0.574), (-174.533, 174.533), 7, 0.838, at=3.142),
    _joint("Jaco_joint6", (0, 0.1177, 0.9684), (0, -0.94, 0.342), (-174.533, 174.533), 7, 0.838, at=3.142),
    Stock("Jaco_connection", FORCE, (0, 0.1177, 0.9684), (0, 0.94, -0.342)),
)
"""Jaco arm."""

MICO = (
    Stock("Mico", SHAPE, (0, 0, 0.0784), euler_deg=(0.0, 0.0, 0.0)),
    _joint("Mico_joint1", (0, 0, 0.1567), (0, 0, -1), (-174.533, 174.533), 26, 0.628, at=3.142),
    _joint("Mico_joint2", (0, 0, 0.2755), (0, 1, 0), (0.820, 5.463), 26, 0.628, at=3.142),
    _joint("Mico_joint3", (0, 0, 0.5655), (0, -1, 0), (0.332, 5.952), 26, 0.628, at=3.142),
    _joint("Mico_joint4", (0, 0.007, 0.6887), (0, 0, -1), (-174.533, 174.533), 7, 0.838, at=3.142),
    _joint("Mico_joint5", (0, 0.044, 0.7529), (0, -0.866, -0.5), (-174.533, 174.533), 7, 0.838, at=3.142),
    _joint("Mico_joint6", (0, 0.118, 0.7528), (0, -0.866, 0.5), (-174.533, 174.533), 7, 0.838, at=3.142),
    Stock("Mico_connection", FORCE, (0, 0.118, 0.7528), (0, 0.866, -0.5)),
)
"""Mico arm."""

REDUNDANT = (
    Stock("redundantRobot", SHAPE, (0, 0, 0.0647), euler_deg=(0.0, 0.0, 0.0)),
    Stock("redundantRob_target", DUMMY, (0.324, 0, 0.62)),
    _joint("redundantRob_joint1", (0, 0, 0.0647), (0, 0, 1), "cyclic", 1000, 6.28, mode=IK_MODE),
    _joint("redundantRob_joint2", (0, 0, 0.2039), (0, -1, 0), "cyclic", 1000, 6.28, mode=IK_MODE),
    _joint("redundantRob_joint3", (0, 0, 0.3004), (0, 0, 1), "cyclic", 1000, 6.28, mode=IK_MODE),
    _joint("redundantRob_joint4", (0, 0, 0.4951), (0, -1, 0), "cyclic", 1000, 6.28, mode=IK_MODE),
    _joint("redundantRob_joint5", (0.0901, 0, 0.4951), (1, 0, 0), "cyclic", 1000, 6.28, mode=IK_MODE),
    _joint("redundantRob_joint6", (0.3236, 0, 0.4951), (0, -1, 0), "cyclic", 1000, 6.28, mode=IK_MODE),
    _joint("redundantRob_joint7", (0.3236, 0, 0.5557), (0, 0, 1), "cyclic", 1000, 6.28, mode=IK_MODE),
    Stock("redundantRob_tip", DUMMY, (0.324, 0, 0.62)),
)
"""7 DoF manipulator."""

IRB140 = (
    Stock("IRB140", SHAPE, (0, 0, 0.0771), euler_deg=(0.0, 0.0, 0.0)),
    Stock("IRB140_manipulationSphereBase", DUMMY, (0.519, 0, 0.6516)),
    Stock("IRB140_target", DUMMY, (0.519, 0, 0.6516)),
    _joint("IRB140_joint1", (0.069, 0, 0), (0, 0, 1), "cyclic", 2000, 1.57, mode=IK_MODE),
    _joint("IRB140_joint2", (0.139, 0, 0.3521), (0, -1, 0), (-1.920, 1.571), 2000, 1.57, mode=IK_MODE),
    _joint("IRB140_joint3", (0.139, 0, 0.7121), (0, -1, 0), (-0.873, 4.014), 2000, 1.57, mode=IK_MODE),
    _joint("IRB140_joint4", (0.365, 0, 0.7121), (1, 0, 0), "cyclic", 2000, 1.57, mode=IK_MODE),
    _joint(
        "IRB140_joint5", (0.519, 0, 0.7121), (0, -1, 0), (-2.094, 2.094), 2000, 1.57, at=-1.571, mode=IK_MODE
    ),
    _joint("IRB140_joint6", (0.519, 0, 0.6661), (0, 0, -1), "cyclic", 200, 1.57, mode=IK_MODE),
    Stock("IRB140_tip", DUMMY, (0.519, 0, 0.6516)),
    Stock("IRB140_connection", FORCE, (0.519, 0, 0.6471), (0, 0, -1)),
)
"""ABB IRB 140."""

UR3 = (
    Stock("UR3", SHAPE, (0, 0, 0.0430), euler_deg=(0.0, 0.0, 0.0)),
    _joint("UR3_joint1", (0.0001, 0.0001, 0.1475), (0, 0, 1), (-6.283, 6.283), 50, 3.14),
    _joint("UR3_joint2", (-0.1115, 0, 0.1519), (-1, 0, 0), (-6.283, 6.283), 50, 3.14),
    _joint("UR3_joint3", (-0.1115, 0.0001, 0.3955), (-1, 0, 0), (-6.283, 6.283), 50, 3.14),
    _joint("UR3_joint4", (-0.1115, 0.0001, 0.6088), (-1, 0, 0), (-6.283, 6.283), 50, 6.28),
    _joint("UR3_joint5", (-0.1122, 0.0001, 0.693), (0, 0, 1), (-6.283, 6.283), 50, 6.28),
    _joint("UR3_joint6", (-0.1115, 0.0001, 0.6941), (-1, 0, 0), "cyclic", 50, 6.28),
    Stock("UR3_connection", FORCE, (-0.194, 0.0001, 0.6941), (-1, 0, 0)),
)
"""UR3."""

UR10 = (
    Stock("UR10", SHAPE, (0, 0, 0.0190), euler_deg=(0.0, 0.0, 90.0)),
    _joint("UR10_joint1", (-0.0086, 0, 0.0447), (0, 0, 1), (-6.283, 6.283), 200, 2.09),
    _joint("UR10_joint2", (-0.1012, 0, 0.128), (-1, 0, 0), (-6.283, 6.283), 200, 2.09),
    _joint("UR10_joint3", (-0.1207, 0.0006, 0.7401), (-1, 0, 0), (-6.283, 6.283), 200, 2.09),
    _joint("UR10_joint4", (-0.1141, 0, 1.3123), (-1, 0, 0), (-6.283, 6.283), 200, 2.09),
    _joint("UR10_joint5", (-0.1725, 0, 1.3696), (0, 0, 1), (-6.283, 6.283), 200, 2.09),
    _joint("UR10_joint6", (-0.2298, 0, 1.428), (-1, 0, 0), (-6.283, 6.283), 200, 2.09),
    Stock("UR10_connection", FORCE, (-0.2572, 0, 1.428), (-1, 0, 0)),
)
"""UR10."""

_UR5_HEIGHTS = (0.0231, 0.0892, 0.5143, 0.9064, 0.9520, 1.0012)

UR5 = (
    Stock("UR5", SHAPE, (0, 0, 0.0147), euler_deg=(0, 0, 0)),
    *(
        _joint(f"UR5_joint{number}", (x, 0, z), axis, (-6.283, 6.283), 160, 3.14)
        for number, x, z, axis in zip(
            range(1, 7),
            (0, -0.0703, -0.0703, -0.0703, -0.11, -0.0956),
            _UR5_HEIGHTS,
            ((0, 0, 1), (-1, 0, 0), (-1, 0, 0), (-1, 0, 0), (0, 0, 1), (-1, 0, 0)),
            strict=True,
        )
    ),
    Stock("UR5_connection", FORCE, (-0.185, 0, 1.0012), (-1, 0, 0)),
)
"""UR5; it is not in the stock models' tables but in the tutorial scene's."""


def _finger(side: str, sign: int, least: float, greatest: float) -> tuple[Stock, ...]:
    free: Vector = (0, -1, 0)
    return (
        _joint(f"RG2_{side}Joint0", (sign * 0.017, 0, 0.105), free, (least, greatest), 2.5, 6.28),
        _joint(f"RG2_{side}Joint1", (sign * 0.0426, 0, 0.1537), free, "cyclic", 2.5, 6.28),
        _joint(f"RG2_{side}Joint2", (sign * 0.0075, 0, 0.1215), free, "cyclic", 2.5, 6.28),
        Stock(f"RG2_{side}ForceSensor", FORCE, (sign * 0.0258, 0, 0.1916), (-sign, 0, 0)),
        Stock(f"RG2_{side}LoopDummyA", DUMMY, (sign * 0.0331, 0, 0.1702)),
        Stock(f"RG2_{side}LoopDummyB", DUMMY, (sign * 0.0331, 0, 0.1702)),
        *(Stock(f"RG2_{side}{part}", SHAPE, mass=0.0454) for part in ("Link0", "Link1", "Touch", "Link2")),
        Stock(
            f"RG2_{side}Joint3",
            PRISMATIC,
            (sign * 0.0203, 0, 0.1458),
            (-0.465, 0, -sign * 0.885),
            max_force=50,
        ),
    )


RG2 = (
    Stock("RG2", SHAPE, (0, 0, 0.0045), euler_deg=(0, 0, 0), mass=0.075),
    Stock("RG2_upperBase", SHAPE, mass=0.075),
    *_finger("left", 1, -0.960, 0.4712),
    *_finger("right", -1, -0.4712, 0.960),
    Stock(
        "RG2_openCloseJoint",
        PRISMATIC,
        (-0.0258, 0, 0.1916),
        (1, 0, 0),
        interval=(-0.048, 0.0538),
        mode=FORCE_MODE,
        position_q=0,
        max_force=20,
        upper_velocity=0.11,
    ),
    Stock("RG2_openCloseLoopDummyA", DUMMY, (0.0258, 0, 0.1916)),
    Stock("RG2_openCloseLoopDummyB", DUMMY, (0.0258, 0, 0.1916)),
    Stock("RG2_centerJoint0", PRISMATIC, (0, 0, 0.1916), (0, 0, 1), max_force=50),
    Stock("RG2_centerJoint1", PRISMATIC, (0, 0, 0.1916), (1, 0, 0), max_force=200, upper_velocity=0.08),
    Stock("RG2_centerLoopDummyA", DUMMY, (-0.0258, 0, 0.1916)),
    Stock("RG2_centerLoopDummyB", DUMMY, (-0.0258, 0, 0.1916)),
    Stock("RG2_attachPoint", FORCE, (0, 0, 0.149), (0, 0, 1)),
    Stock("RG2_attachProxSensor", RAY, (0, 0, 0.149), (0, 0, 1), reach=0.05, offset=0.01, explicit=True),
    Stock("RG2_lowerUpperBaseConnection", FORCE, (0, 0, 0.025), (0, 0, 1)),
)
"""RG2, standing on its flange face. The outer cranks reach 2 degrees further than V-REP's 0.436, to where its
pads meet, and the frame of RG2_openCloseJoint is at the right pad, not between the two."""

JACO_HAND = (
    Stock("JacoHand", SHAPE),
    *(
        Stock(f"JacoHand_{fingers}_motor{number}", PRISMATIC, mode=FORCE_MODE, position_q=0)
        for fingers in ("fingers12", "finger3")
        for number in (1, 2)
    ),
    *(
        Stock(f"JacoHand_joint{number}_finger{finger}", REVOLUTE, mode=FORCE_MODE, position_q=0)
        for finger in (1, 2, 3)
        for number in (1, 2)
    ),
    *(Stock(f"JacoHand_forceSens2_finger{finger}", FORCE) for finger in (1, 2, 3)),
    Stock("JacoHand_attachPoint", FORCE),
    Stock("JacoHand_attachProxSensor", RAY, explicit=True),
)
"""The names that public scripts use; nobody tells its places."""

FRANKA = (
    Stock("Franka", SHAPE),
    *(
        _joint(f"Franka_joint{number}", place, axis, interval, force, velocity, at=at)
        for number, (place, axis, interval, force, velocity, at) in enumerate(
            (
                ((0, 0, 0.333), (0, 0, 1), (-2.897, 2.897), 87, 2.175, 0),
                ((0, 0, 0.333), (0, 1, 0), (-1.763, 1.763), 87, 2.175, 0),
                ((0, 0, 0.649), (0, 0, 1), (-2.897, 2.897), 87, 2.175, 0),
                ((0.0825, 0, 0.649), (0, -1, 0), (-3.072, -0.07), 87, 2.175, -1.571),
                ((0.4665, 0, 0.7315), (1, 0, 0), (-2.897, 2.897), 12, 2.61, 0),
                ((0.4665, 0, 0.7315), (0, -1, 0), (-0.018, 3.752), 12, 2.61, 1.571),
                ((0.5545, 0, 0.7315), (0, 0, -1), (-2.897, 2.897), 12, 2.61, 0),
            ),
            1,
        )
    ),
    Stock("Franka_connection", FORCE, (0.5545, 0, 0.6245), (0, 0, -1)),
)
"""Franka Emika Panda: limits as PyRep's copy has them, places by the maker's table at the pose it starts in."""

ARMS = {
    "models/robots/non-mobile/UR3.ttm": UR3,
    "UR5.ttm": UR5,
    "UR10.ttm": UR10,
    "KUKA LBR iiwa 7 R800.ttm": LBR_IIWA_7,
    "KUKA LBR iiwa 14 R820.ttm": LBR_IIWA_14,
    "KUKA LBR4+.ttm": LBR4P,
    "Jaco arm.ttm": JACO,
    "Mico arm.ttm": MICO,
}
IK_ARMS = {"7 DoF manipulator.ttm": REDUNDANT, "ABB IRB 140.ttm": IRB140}
"""Their joints are in inverse kinematics mode, as saved."""
OTHERS = {
    "FrankaEmikaPanda.ttm": FRANKA,
    "RG2.ttm": RG2,
    "Jaco hand.ttm": JACO_HAND,
}
MODELS = ARMS | IK_ARMS | OTHERS
"""By stock file name."""

SCENES = {
    "ur3": UR3,
    "ur5": UR5,
    "ur10": UR10,
    "lbr_iiwa_7_r800": LBR_IIWA_7,
    "jaco": JACO,
}
"""The arm in each of the shipped scenes."""
