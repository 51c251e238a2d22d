"""The old custom UIs of a V-REP file as annotations; `scene/formats/texts/old_uis.py` describes their form."""

from __future__ import annotations

import json
import math
from typing import Any

from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import PREFIX
from simx_server.scene.formats.texts.old_uis import MAX_ELEMENTS, MAX_PROPERTIES, UI_TEXT, check_property
from simx_server.scene.formats.vrep.objects import Button, OldUI

from .context import Conversion
from .unique_names import UniqueNames

_TITLE = 0
"""Id of the label with the title, in every UI that V-REP's dialog has made."""


def add_uis(conversion: Conversion) -> None:
    """Add an annotation for each UI to the spec."""
    unique = UniqueNames("{}#{}")
    for ui in conversion.file.uis:
        name = unique.take(ui.name or "UI")
        conversion.spec.add_text(
            name=f"{PREFIX}{UI_TEXT}:{name}", data=json.dumps(_described(conversion, ui), ensure_ascii=False)
        )


def _described(conversion: Conversion, ui: OldUI) -> dict[str, Any]:
    elements: dict[int, dict[str, Any]] = {}
    if len(ui.buttons) > MAX_ELEMENTS:
        conversion.report.leave_out(f"elements of custom UIs beyond the first {MAX_ELEMENTS}", ui.name)
    for button in ui.buttons[:MAX_ELEMENTS]:
        described = _element(conversion, ui, button)
        if described is not None:
            elements.setdefault(button.handle, described)
    title = next((button.label for button in ui.buttons if button.handle == _TITLE), "")
    found: dict[str, Any] = {
        "title": title or ui.name,
        "properties": ui.attributes & MAX_PROPERTIES,
        "size": list(ui.size),
        "element": list(elements.values()),
    }
    if ui.object in conversion.names:
        found["object"] = conversion.names[ui.object]
    return found


def _element(conversion: Conversion, ui: OldUI, button: Button) -> dict[str, Any] | None:
    try:
        check_property(button.attributes)
    except CommandError:
        conversion.report.leave_out("buttons of custom UIs whose kind is not known", ui.name)
        return None
    found: dict[str, Any] = {
        "id": button.handle,
        "property": button.attributes,
        "place": [*button.position, *button.size],
    }
    if button.label:
        found["label"] = button.label
    if button.down_label:
        found["down_label"] = button.down_label
    if button.slider:
        found["position"] = min(max(button.slider, 0), 1000)
    if button.colors is not None:
        found["colors"] = [[_share(part) for part in color] for color in button.colors]
    return found


def _share(number: float) -> float:
    """Return a number of a file from 0 to 1, also for one that is not a number."""
    return round(min(max(number, 0.0), 1.0), 3) if math.isfinite(number) else 0.0
