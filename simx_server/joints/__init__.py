"""V-REP's joints on MuJoCo's: modes, motors, position and velocity control, forces.

The semantics, per joint in force mode with the motor on:
* control loop on: each physics step the commanded velocity is P / 0.005 s * (target - position) (plus I and D), limited
  to the upper velocity, the force to the maximum force: V-REP's controller at its standard 5 ms dynamics step;
* control loop off: the target velocity; at zero with the lock on, the position reached is held;
* motor off: no force at all, and no gravity compensation of the driven body: it falls.
Other modes are kinematic: the joint stays where it was set.
"""

from simx_server.joints.joints import Joints
from simx_server.joints.state import JointMode, JointState

__all__ = ["JointMode", "JointState", "Joints"]
