"""The server as the router of ROS 2's nodes: its Zenoh options and access rules.

ROS 2's nodes are equals: each may publish any topic and offer any service. The rules allow the keys of ROS 2 and
nothing else, such as the router's own data below ``@``, and keep the services of the server's own node to it.
"""

from __future__ import annotations

from typing import Any

from simx_client.protocol.zenoh import link
from simx_client.protocol.zenoh.access import BOTH, rule, section

from .names import Place

_ALL = (
    "put", "delete", "declare_subscriber", "query", "declare_queryable", "reply", "liveliness_token",
    "liveliness_query", "declare_liveliness_subscriber",
)  # fmt: skip
"""Kinds of messages that rules are about."""

_KEYS = ("*/*/**", "*/*/**/@adv/**", "@ros2_lv/**")
"""Topics and services; caches of transient-local topics; the graph. ``**`` matches no chunk that starts with ``@``."""


def options(endpoint: str, place: Place) -> dict[str, Any]:
    """Return the options of the session that listens at `endpoint` for ROS 2's nodes.

    Args:
        endpoint: where the nodes connect.
        place: of the server's own node.
    """
    return {
        "mode": "router",
        "listen/endpoints": [endpoint],
        "scouting/gossip/enabled": True,  # by which ROS 2's nodes find each other
        "scouting/delay": 0,  # others connect to it; Zenoh would wait half a second before it opens
        "transport/unicast/accept_pending": link.MOST_PENDING,
        "access_control": rules(place),
    }


def rules(place: Place) -> dict[str, Any]:
    """Return Zenoh's ``access_control`` section."""
    own = f"{place.domain}{place.full('~')}/**"
    return section(
        [
            rule("ros2", BOTH, _KEYS, *_ALL),
            rule("own services", ["ingress"], [own], "declare_queryable", "reply", permission="deny"),
        ]
    )
