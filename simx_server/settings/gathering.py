"""Gather the settings of a server from parsed flags and the environment."""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from . import rules
from .conflicts import refuse_conflicts
from .settings import SETTINGS, Settings


def gather(flags: Mapping[str, Any], environment: Mapping[str, str]) -> Settings:
    """Make settings from parsed flags (field name to text, list of texts or bool) and the environment.

    An empty variable counts as absent. Raises SettingError for the first bad value.
    """
    values: dict[str, Any] = {}
    origins: dict[str, str] = {}
    for name, setting in SETTINGS.items():
        given: Any
        if name in flags:
            origin = "argument " + setting.flag if setting.is_positional else "flag " + setting.flag
            given = flags[name]
        elif text := environment.get(setting.variable, "").strip():
            origin = "environment " + setting.variable
            given = re.split(r"[,\s]+", text.strip(" ,")) if setting.many else text
        else:
            continue
        origins[name] = origin
        if isinstance(given, bool):
            values[name] = given
        elif setting.many:
            values[name] = tuple(setting.read(text, origin) for text in given)
        else:
            values[name] = setting.read(given, origin)
    if "ports" not in values and (legacy := values.get("legacy_ports")):
        values["ports"] = _give_way(legacy)
    if values.get("teleop") is not None and "view" not in values:
        values["view"] = SETTINGS["view"].read(SETTINGS["view"].lone, origins["teleop"])
        origins["view"] = origins["teleop"]
    if values.get("ros2") == rules.FROM_ENVIRONMENT:
        domain = environment.get(rules.FROM_ENVIRONMENT, "").strip() or "0"
        values["ros2"] = SETTINGS["ros2"].read(domain, f"environment {rules.FROM_ENVIRONMENT}")
    settings = Settings(**values, origins=MappingProxyType(origins))
    refuse_conflicts(settings)
    return settings


def _give_way(legacy: tuple[str, ...]) -> tuple[int, ...]:
    """Return the default ports without those that original clients are to find, or a free one if none is left."""
    taken = {rules.port_of(address) for address in legacy}
    default: tuple[int, ...] = Settings.ports
    return tuple(port for port in default if port not in taken) or (0,)
