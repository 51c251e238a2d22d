"""The router of a fleet that joins none: a Ray actor with a Zenoh session.

Without logins it cannot tell servers from clients. Its access rules allow what either of them does and nothing else:
no program listens to everything at once, reads the router's own data, or uses it for other keys.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from simx_client.protocol.zenoh import keys, link
from simx_client.protocol.zenoh.access import BOTH, rule, section

from .ray import load_ray

MOST_SESSIONS = 100_000
"""Programs that are connected at a time; Zenoh's default is 1,000."""


class Router:
    """A Zenoh router, for fleets without one."""

    def __init__(self, endpoint: str) -> None:
        """Listen.

        Raises:
            RuntimeError: the endpoint cannot be used.
        """
        # With the threads of a server: connections that say nothing keep some of them busy.
        zenoh: Any = link.import_zenoh(link.CONFIGURED_SERVER_RUNTIME)
        self._endpoint = endpoint
        try:
            self._session = zenoh.open(link.configure(zenoh.Config(), options(endpoint)))
        except zenoh.ZError as error:
            raise RuntimeError(f"no router at {endpoint}: {error}; choose another with --listen") from None

    def describe(self) -> str:
        """Return the endpoint by which the hosts of the cluster reach it."""
        return reachable(self._endpoint, load_ray().util.get_node_ip_address())

    def end(self) -> None:
        """Close the session."""
        self._session.close()


def options(endpoint: str) -> dict[str, Any]:
    """Return the options of the router's session; docs/operators/scaling.md has them for other routers."""
    return {
        **link.SERVER,
        "mode": "router",
        "listen/endpoints": [endpoint],
        "transport/unicast/max_sessions": MOST_SESSIONS,
        "access_control": rules(),
    }


def rules() -> dict[str, Any]:
    """Return Zenoh's ``access_control`` section: what servers and clients of any realm do, in both directions."""
    asked = [key("*") for key in (keys.hello, keys.status, keys.health, keys.metrics)]
    sent = [keys.reply("*", "*"), keys.stream("*", "*"), keys.image("*", "*")]
    names = [keys.client("*"), keys.ANY_ALIVE]
    listed = [
        rule("questions", BOTH, asked, "query", "declare_queryable", "reply"),
        rule("names", BOTH, names, "liveliness_token", "liveliness_query", "declare_liveliness_subscriber"),
        rule("calls and answers", BOTH, [keys.call("*"), *sent], "put", "declare_subscriber"),
    ]
    return section(listed)


def reachable(endpoint: str, host: str) -> str:
    """Return an endpoint with the address of its host if it listens at all of them: 0.0.0.0 is for listening only."""
    shown = f"[{host}]" if ":" in host else host
    return re.sub(r"/(0\.0\.0\.0|\[::\])(?=:)", lambda _: f"/{shown}", endpoint)


def is_loopback(endpoints: Sequence[str]) -> bool:
    """Return whether other hosts cannot reach any of the endpoints."""
    return all(re.search(r"/(127\.|localhost|\[?::1\b)", each) for each in endpoints)
