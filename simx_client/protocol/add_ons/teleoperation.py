"""Teleoperation of an arm by an add-on of the server, and the marks of demonstrations.

==========  ===========================  ==================  =========================================================
function    floats                       strings             effect
==========  ===========================  ==================  =========================================================
drive       x, y, z in m/s;              arm; empty: the     The tip moves at this velocity, along and about the axes
            about x, y, z in rad/s       one of before       of the world, until `HELD` seconds are over.
reach       x, y, z in m;                arm                 The tip moves to this pose in the world, as fast as it
            quaternion x, y, z, w                            may, until `HELD` seconds are over.
gripper     (one integer) 1 open,        arm                 The gripper opens or closes.
            0 close
release                                                      The arm stops.
arms                                     arm                 Returns `Arms`, by MessagePack in the buffer.
==========  ===========================  ==================  =========================================================

An arm is the name of its tip, or of an object that carries its joints.
"""

from __future__ import annotations

from typing import TypedDict

ADD_ON = "simxTeleoperation"
ADD_ON_TYPE = 2
"""Script type, as in simxCallScriptFunction."""

DRIVE, REACH, GRIPPER, RELEASE, ARMS = "drive", "reach", "gripper", "release", "arms"

HELD = 0.3
"""Simulated seconds after which the arm stops, unless another call follows: an operator may be gone."""

SPEED, TURN = 0.25, 1.0
"""Greatest velocities of the tip: m/s, rad/s."""

MARK = "demonstration"
"""The integer signal that marks episodes in a recording; see docs/demonstrations.md."""

STARTED, SUCCEEDED, DISCARDED = 1, 2, 3
"""Its values."""


class Arms(TypedDict):
    """The arms of a scene, and the state of one of them."""

    names: list[str]
    """The tips of all arms; empty: there is none."""

    tip: str
    """The tip of the chosen arm; empty: there is none."""

    problem: str
    """Why there is none; else empty."""

    gripper: str
    """The signal or joint that moves the gripper; empty: the arm has none that is known."""

    is_open: bool
    """The last command to the gripper."""

    position: list[float]
    """Of the tip in the world, m."""

    quaternion: list[float]
    """x, y, z, w"""

    base: list[float]
    """Orientation of the arm's base in the world: quaternion x, y, z, w."""

    is_driven: bool
    """Whether a call holds the arm now."""
