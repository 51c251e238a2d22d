"""List all settings with their values, for ``--show-settings``."""

from __future__ import annotations

import math

from .settings import SETTINGS, Settings


def list_settings(settings: Settings) -> list[tuple[str, str, str]]:
    """Return (name as in the flag, value as text, origin) of every setting, in order of declaration."""
    return [
        (
            setting.flag.lstrip("-").lower(),
            setting.unset if (value := getattr(settings, name)) is None else _shown(value),
            settings.origins.get(name, "default"),
        )
        for name, setting in SETTINGS.items()
    ]


def _shown(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(str, value)) or "none"  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value == math.inf:
        return "max"
    return str(value)
