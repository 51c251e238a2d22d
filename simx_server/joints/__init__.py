"""V-REP's joints on MuJoCo's: modes, motors, position and velocity control, forces.

A motor keeps the commanded velocity with at most its maximum force, as in V-REP's engines (`stepping/motors.py`). In
force mode with the motor on:
* control loop on: in each physics step the commanded velocity removes the part of the error (target - position) that
  V-REP's controller removes in the same time: P in each of its dynamics steps of 5 ms; plus I and D, limited to the
  upper velocity;
* control loop on, spring and damper: the force is K * (target - position) - C * velocity, within the maximum force;
  one that is too stiff for the joint's inertia is a motor with that force, at most at the target velocity;
* control loop off: the joint moves at the target velocity; at zero with the lock on, it holds the position reached;
* motor off: no force and no gravity compensation of the driven body, which falls; a joint that is rewound (rollers
  around a wheel) turns freely but stays in place.

The other modes are kinematic. Passive and IK (which this package does not compute): the joint stays where it was
set. Motion: it moves at its target velocity. Dependent: it follows its master. In hybrid operation the joint's
motor drives it, under position control, to where its mode puts it. A spherical joint has no motor: it is free in
force mode, else it stays.
"""

from .joints import Joints
from .state import JointMode, JointState

__all__ = ["JointMode", "JointState", "Joints"]
