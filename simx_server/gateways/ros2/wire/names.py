"""Names of ROS 2 and their form in Zenoh: key expressions, and liveliness tokens that make the graph.

A topic is the key `DOMAIN/NAME/DDS TYPE/HASH`. A token below ``@ros2_lv`` makes a node, a topic or a service visible in
``ros2 node list`` and the like; its parts have ``%`` for each ``/``.
"""

from __future__ import annotations

import re
from enum import Enum
from typing import NamedTuple

from .qos import Qos

NODE = "simx"
"""The name of the server's node."""

NO_HASH = "TypeHashNotSupported"
"""The hash of every type in Humble."""

_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_BAD = re.compile(r"[^A-Za-z0-9_]+")


class Distribution(Enum):
    """The distributions of ROS 2 that differ in what is sent."""

    HUMBLE = "humble"
    NEWER = "iron and later"

    def hash_of(self, type_hash: str) -> str:
        """Return the hash that this distribution writes for a type with the given one."""
        return NO_HASH if self is Distribution.HUMBLE else type_hash


class Kind(Enum):
    """The kind of an endpoint, as its token names it."""

    PUBLISHER = "MP"
    SUBSCRIPTION = "MS"
    SERVER = "SS"
    CLIENT = "SC"


class Place(NamedTuple):
    """Where a node is: its domain, and the namespace in front of its names."""

    domain: int = 0
    namespace: str = ""
    """Empty, or a name with a slash in front: `/arm`."""

    node: str = NODE

    def full(self, name: str) -> str:
        """Return the full name of a topic or service; `~` at its start is the node's own name.

        Args:
            name: with a slash in front, such as `/joint_states`, or `~/start`.
        """
        return self.namespace + (f"/{self.node}{name[1:]}" if name.startswith("~") else name)


def is_name(text: str) -> bool:
    """Return whether a text is a full name of ROS 2, such as `/arm/joint_states`."""
    return text.startswith("/") and all(map(_TOKEN.fullmatch, text[1:].split("/")))


def part_of_name(text: str) -> str:
    """Return a text as one part of a name: a sensor `Vision_sensor#0` is `Vision_sensor_0`."""
    part = _BAD.sub("_", text).strip("_") or "unnamed"
    return part if _TOKEN.fullmatch(part) else f"_{part}"


def key(place: Place, full_name: str, dds_type: str, type_hash: str) -> str:
    """Return the key expression of a topic or service.

    Args:
        full_name: with namespace.
        dds_type: such as `sensor_msgs::msg::dds_::JointState_`.
        type_hash: as the distribution writes it, or `*` for those of all distributions.
    """
    return f"{place.domain}/{full_name.strip('/')}/{dds_type}/{type_hash}"


def node_token(place: Place, zid: str, node_id: int | str) -> str:
    """Return the token that makes the node visible.

    Args:
        zid: the id of the Zenoh session, or `*` to find nodes of any session.
        node_id: that of the node within the session, or `*`.
    """
    return f"@ros2_lv/{place.domain}/{zid}/{node_id}/{node_id}/NN/%/{_mangled(place.namespace)}/{place.node}"


def endpoint_token(
    place: Place,
    zid: str,
    ids: tuple[int, int],
    kind: Kind,
    full_name: str,
    dds_type: str,
    type_hash: str,
    qos: Qos,
) -> str:
    """Return the token that makes a topic or service visible.

    Args:
        zid: the id of the Zenoh session.
        ids: the node's, and the endpoint's own, different from all others of the session.
        full_name: with namespace.
        type_hash: as the distribution writes it.
    """
    node_id, endpoint_id = ids
    return (
        f"@ros2_lv/{place.domain}/{zid}/{node_id}/{endpoint_id}/{kind.value}/%/{_mangled(place.namespace)}/"
        f"{place.node}/{_mangled(full_name)}/{dds_type}/{type_hash}/{qos.text()}"
    )


def _mangled(name: str) -> str:
    return name.replace("/", "%") or "%"
