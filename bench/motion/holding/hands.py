"""The grippers whose grasps are measured: those that the project ships, and some of V-REP's model folder."""

from __future__ import annotations

from collections.abc import Mapping

from bench.motion.holding.grasps import Hand

_RG2 = ("RG2_openCloseJoint",)
_ROBOTIQ = ("ROBOTIQ_85_active1", "ROBOTIQ_85_active2")
_JACO = tuple(f"JacoHand_{fingers}_motor{i}" for fingers in ("fingers12", "finger3") for i in (1, 2))
_MICO = tuple(f"MicoHand_fingers12_motor{i}" for i in (1, 2))
_CABLES = ("Barrett_openCloseJoint", "Barrett_openCloseJoint0")
_BARRETT = tuple(f"BarrettHand_jointB_{i}" for i in range(3))

SHIPPED: Mapping[str, Hand] = {
    "rg2.xml": Hand("RG2", 0.19, dict.fromkeys(_RG2, 0.05), dict.fromkeys(_RG2, -0.05), signal="RG2_open"),
    "jaco_hand.xml": Hand("JacoHand", 0.16, dict.fromkeys(_JACO, 0.04), dict.fromkeys(_JACO, -0.04)),
}
"""By file in `scenes/models`."""

STOCK: Mapping[str, Hand] = {
    "RG2.ttm": Hand("RG2", 0.19, dict.fromkeys(_RG2, 0.05), dict.fromkeys(_RG2, -0.05), signal="RG2_open"),
    "ROBOTIQ 85.ttm": Hand(
        "ROBOTIQ_85",
        0.13,
        dict.fromkeys(_ROBOTIQ, 0.04),
        dict.fromkeys(_ROBOTIQ, -0.04),
        button=("ROBOTIQ_85_UI", 3),
    ),
    "Jaco hand.ttm": Hand("JacoHand", 0.205, dict.fromkeys(_JACO, 0.04), dict.fromkeys(_JACO, -0.04)),
    "Mico hand.ttm": Hand(
        "MicoHand",
        0.195,
        dict.fromkeys(_MICO, 0.04),
        dict.fromkeys(_MICO, -0.04),
        button=("MicoHand", 20),
    ),
    "Barrett Hand (simplified).ttm": Hand(
        "BarrettHand",
        0.17,
        dict.fromkeys(_CABLES, 0.02),
        dict.fromkeys(_CABLES, -0.02),
        button=("BarrettHand", 20),
        closing=8.0,
    ),
    "Barrett Hand.ttm": Hand(
        "BarrettHand",
        0.19,
        dict.fromkeys(_BARRETT, -1),
        dict.fromkeys(_BARRETT, 1),
        button=("BarrettHand", 20),
        closing=10.0,
    ),
}
"""By file in V-REP's `models/components/grippers`."""
