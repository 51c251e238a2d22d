"""The settings of a vision sensor as an annotation and attributes of its camera, which give the same settings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from simx_server.scene.formats.texts.filter_chains import write_chain
from simx_server.scene.saved import numbers_text

from .vision_settings import VisionSettings

if TYPE_CHECKING:
    from simx_server.scene.objects import SceneObject
    from simx_server.scene.saved import Saved


def save_settings(saved: Saved, item: SceneObject, settings: VisionSettings, first: VisionSettings) -> None:
    """Save what differs from the first settings, which annotation and camera have given."""
    handle = item.handle

    def differs(*names: str) -> bool:
        return any(getattr(settings, name) != getattr(first, name) for name in names)

    of_scene = ("near", "far") if saved.is_model else ()  # they follow from the size of the whole scene
    for name in ("near", "far", "explicit", "external", "detect_above", "detect_below"):
        if differs(name) or name in of_scene:
            saved.put(handle, "vision", **{name: getattr(settings, name)})
    for name in ("rgb", "depth", "statistics"):
        if differs(f"has_{name}"):
            saved.put(handle, "vision", **{name: getattr(settings, f"has_{name}")})
    if differs("shows_handles"):
        saved.put(handle, "vision", render="handles" if settings.shows_handles else "colours")
    if differs("background"):
        colour = settings.background
        saved.put(handle, "vision", background=None if colour is None else numbers_text(colour))
    if differs("chain"):
        chain = settings.chain
        saved.put(handle, "vision", filters="none" if chain is None else write_chain(chain.components))
    camera: Any = saved.spec.camera(item.element_name)
    if differs("width", "height", "angle", "orthographic_size"):
        width, height = settings.width, settings.height
        camera.resolution[:] = width, height
        single = True if width * height <= 1 else None
        saved.put(handle, "vision", angle_deg=math.degrees(settings.angle), single_pixel=single)
        if settings.orthographic_size is not None:
            camera.fovy = settings.orthographic_size / max(1.0, width / height)
