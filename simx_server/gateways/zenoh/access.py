"""Define the access rules of the server's Zenoh session: clients may do what a client needs, and nothing else.

A Zenoh peer forwards messages between its neighbours. Without rules, one client could answer the greetings of other
clients, send them replies and receive their calls. A rule matches only the key expressions that it includes. Everything
outside the list is denied: no rule includes a subscription to ``**``, but one includes ``simx/REALM/reply/*``.
"""

from __future__ import annotations

import json
from typing import Any

from simx_client.protocol.zenoh import keys
from simx_client.protocol.zenoh.access import rule, section

_PERMISSION = "access_control/enabled"


def rules(realm: str) -> dict[str, Any]:
    """Return Zenoh's ``access_control`` section for a server with this realm."""
    asked = [key("*") for key in (keys.hello, keys.status, keys.health, keys.metrics)]
    own = [key(realm) for key in (keys.hello, keys.status, keys.health, keys.metrics)]
    sent = [keys.reply(realm, "*"), keys.stream(realm, "*"), keys.image(realm, "*")]
    listed = [
        # allowed for messages that arrive
        rule("ask", ["ingress"], asked, "query"),
        rule("find", ["ingress"], [keys.ANY_ALIVE], "liveliness_query", "declare_liveliness_subscriber"),
        rule("be-there", ["ingress"], [keys.client(realm)], "liveliness_token"),
        rule("call", ["ingress"], [keys.call(realm)], "put"),
        rule("listen", ["ingress"], sent, "declare_subscriber"),
        # allowed for messages that leave
        rule("answer", ["egress"], own, "declare_queryable", "reply"),
        rule("send", ["egress"], sent, "put"),
        rule("take-calls", ["egress"], [keys.call(realm)], "declare_subscriber"),
        rule(
            "see-clients",
            ["egress"],
            [keys.client(realm)],
            "liveliness_query",
            "declare_liveliness_subscriber",
        ),
        rule("be-found", ["egress"], [keys.alive(realm)], "liveliness_token"),
    ]
    return section(listed)


def has_rules(config: Any) -> bool:
    """Return whether a Zenoh configuration has its own access rules."""
    return json.loads(config.get_json(_PERMISSION)) is True
