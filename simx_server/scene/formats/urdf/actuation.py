"""Which joints of a URDF have a motor, and what commands it: `<transmission>` of ROS 1, `<ros2_control>` of ROS 2.

V-REP's importer ignores both: each joint gets a motor under position control. Two things follow from them here: a
joint that is commanded by velocity alone starts under velocity control, and a wheel for which a file with such elements
has none turns freely, like a caster.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from xml.etree import ElementTree

_KINDS = ("position", "velocity", "effort")


@dataclass(frozen=True)
class Actuation:
    """The commands of the joints of a file."""

    commands: dict[str, frozenset[str]]
    """Names of joints to kinds of commands: position, velocity, effort, or others."""

    def is_by_velocity(self, joint: str) -> bool:
        """Return whether a joint is commanded by its velocity, and not by its position."""
        kinds = self.commands.get(joint, frozenset())
        return "velocity" in kinds and "position" not in kinds

    def is_without(self, joint: str) -> bool:
        """Return whether the file describes motors, and none for this joint."""
        return bool(self.commands) and joint not in self.commands


def read_actuation(root: ElementTree.Element) -> Actuation:
    """Return the commands of all joints."""
    found: defaultdict[str, set[str]] = defaultdict(set)
    for transmission in root.iter("transmission"):
        whole = [each.text or "" for each in transmission.iter("hardwareInterface")]
        for joint in transmission.iter("joint"):
            own = [each.text or "" for each in joint.iter("hardwareInterface")] or whole
            found[joint.get("name", "")] |= {_kind(text) for text in own}
    for control in root.iter("ros2_control"):
        for joint in control.findall("joint"):
            kinds = {_kind(each.get("name", "")) for each in joint.findall("command_interface")}
            if kinds:
                found[joint.get("name", "")] |= kinds
    return Actuation({name: frozenset(kinds) for name, kinds in found.items() if name})


def _kind(text: str) -> str:
    """Return the kind of a command by the name of an interface, such as ``VelocityJointInterface``."""
    plain = text.strip().rpartition("/")[2].lower()
    return next((kind for kind in _KINDS if plain.startswith(kind)), plain)
