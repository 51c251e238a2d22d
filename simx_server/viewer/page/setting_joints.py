"""Set joints from the web viewer."""

from __future__ import annotations

from typing import Literal

from simx_client import Client
from simx_client.connection.calls import Calls
from simx_server.joints.servo import Rule
from simx_server.joints.state import JointMode
from simx_server.viewer.messages import JointView, SceneItem

from .link import make

Quantity = Literal["position", "target", "velocity"]

_BY_VELOCITY = {Rule.VELOCITY, Rule.HOLD, Rule.MOTION}
_BY_TARGET = {Rule.POSITION, Rule.SPRING, Rule.STIFF_SPRING}


def settable(item: SceneItem, view: JointView) -> Quantity | None:
    """Return the quantity to set for moving the joint; None for a joint that follows another, and ball joints."""
    rule = Rule[view["moved_by"]]
    if view["position"] is None or rule is Rule.DEPENDENT:
        return None
    if rule in _BY_VELOCITY:
        return "velocity"
    if rule in _BY_TARGET:
        return "target" if view["mode"] == JointMode.FORCE else "position"
    return None if item["element"] == "tendon" else "position"


def present(view: JointView, quantity: Quantity) -> float:
    """Return the server's last value, in radians or metres, or those per second."""
    values = {"position": view["position"], "target": view["target"], "velocity": view["target_velocity"]}
    return values[quantity] or 0.0


def set_joint(client: Client, item: SceneItem, quantity: Quantity, value: float) -> None:
    """Set a joint. Raises SimxError.

    While the simulation is stopped no motor moves the joint, so its position is set as well; the target keeps it there
    later. The state is read now, because the viewer's last data may be old.
    """
    joint = item["handle"]
    is_put = quantity == "position"
    if quantity == "target" and item["element"] != "tendon":
        is_put = client.simulation.state == "stopped"

    def note(calls: Calls) -> None:
        if quantity == "velocity":
            calls.simxSetJointTargetVelocity(joint, value)
        if is_put:
            calls.simxSetJointPosition(joint, value)
        if quantity == "target":
            calls.simxSetJointTargetPosition(joint, value)

    make(client, note)
