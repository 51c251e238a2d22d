"""Settings of a scene that programs read: engine, visible layers, whether physics is handled and steps are custom."""

from __future__ import annotations

from simx_server.scene.formats.annotations import ENGINES, WORLD
from simx_server.scene.formats.vrep.conversion.context import Conversion

_NOT_SET = 0x00FF
"""Visible layers of a scene that does not say."""


def add_settings(conversion: Conversion) -> None:
    """Annotate the settings of a scene. A model has none: it takes those of the scene that it is loaded into."""
    if conversion.file.is_model:
        return
    settings = conversion.file.settings
    layers = settings.visible_layers & 0xFFFF
    conversion.annotate(
        "scene",
        WORLD,
        engine=ENGINES[settings.engine],
        layers=f"0x{layers:04x}" if layers != _NOT_SET else None,
        dynamics=None if settings.dynamics else False,
        custom_step=None if settings.has_custom_step else False,
    )
