"""Zenoh's access rules, which allow what they list and deny everything else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

Rule = dict[str, Any]

BOTH = ("ingress", "egress")
"""Messages that arrive, and messages that leave."""


def rule(
    name: str,
    flows: Sequence[str],
    key_expressions: Sequence[str],
    *messages: str,
    permission: str = "allow",
) -> Rule:
    """Return one rule.

    Args:
        name: different from those of the other rules.
        flows: of `BOTH`.
        key_expressions: the rule matches a message whose key expression one of them includes.
        messages: kinds of messages, as Zenoh names them.
        permission: ``allow``, or ``deny``, which wins.
    """
    return {
        "id": name,
        "permission": permission,
        "flows": list(flows),
        "key_exprs": list(key_expressions),
        "messages": list(messages),
    }


def section(rules: Sequence[Rule]) -> dict[str, Any]:
    """Return a configuration's ``access_control`` with these rules for everybody."""
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": list(rules),
        "subjects": [{"id": "everybody"}],
        "policies": [{"rules": [rule["id"] for rule in rules], "subjects": ["everybody"]}],
    }
