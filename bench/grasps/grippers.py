"""The grippers: their files, joints, and where their fingers close."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .program import Array


@dataclass(frozen=True)
class Gripper:
    """A gripper of PyRep."""

    file: str
    """In PyRep's folder `robot_ttms/end_effectors`."""
    base: str
    joints: tuple[str, ...]
    """Those that PyRep's class moves; a velocity below 0 closes all of them."""
    grip: tuple[float, float, float]
    """Where it takes an object, in the frame of its base, m."""
    speed: float = 0.04
    """Velocity of the joints, m/s or rad/s."""
    forwards: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """Direction of the fingers in the frame of the base."""
    across: tuple[float, float, float] = (0.0, 1.0, 0.0)
    """Direction in which they close."""

    def turned_down(self) -> Array:
        """Return the orientation of the base, 3 x 3, with the fingers downwards, closing along x of the world."""
        down, aside = np.array(self.forwards), np.array(self.across)
        return np.array([aside, np.cross(-down, aside), -down])


PANDA = Gripper(
    "PandaGripper.ttm",
    "Panda_gripper",
    ("Panda_gripper_joint1", "Panda_gripper_joint2"),
    grip=(0.0, 0.0018, 0.078),
)
ROBOTIQ_85 = Gripper(
    "Robotiq85.ttm",
    "ROBOTIQ_85",
    ("ROBOTIQ_85_active1", "ROBOTIQ_85_active2"),
    grip=(0.0, -0.0147, 0.095),
    across=(1.0, 0.0, 0.0),
)
JACO = Gripper(
    "JacoHand.ttm",
    "JacoHand",
    tuple(f"JacoHand_joint1_finger{number}" for number in (1, 2, 3)),
    grip=(0.0, 0.0, 0.115),
    speed=0.4,
)
MICO = Gripper(
    "MicoHand.ttm",
    "MicoHand",
    tuple(f"MicoHand_joint1_finger{number}" for number in (1, 3)),
    grip=(0.003, -0.11, 0.0),
    speed=0.4,
    forwards=(0.0, -1.0, 0.0),
    across=(0.0, 0.0, 1.0),
)
BAXTER = Gripper(
    "BaxterGripper.ttm",
    "BaxterGripper",
    ("BaxterGripper_leftJoint", "BaxterGripper_rightJoint"),
    grip=(0.0, -0.0076, 0.08),
    across=(1.0, 0.0, 0.0),
)

GRIPPERS = {
    "Panda": PANDA,
    "Robotiq 85": ROBOTIQ_85,
    "Jaco": JACO,
    "Mico": MICO,
    "Baxter": BAXTER,
}
