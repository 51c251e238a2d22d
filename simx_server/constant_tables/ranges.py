"""Ranges of handles, and the constants of CoppeliaSim 4.11 for objects other than those of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .counting import counted

RANGES: Mapping[str, int] = MappingProxyType(
    {
        "object_sceneobjectstart": 0,
        "object_sceneobjectend": 999_999,
        "object_sceneobjectclassstart": 1_000_000,
        "object_sceneobjectclassend": 1_001_000,
        "object_detachedscriptstart": 1_010_000,
        "object_detachedscriptend": 1_019_999,
        "object_stackstart": 1_020_000,
        "object_stackend": 1_029_999,
        "object_collectionstart": 2_000_000,
        "object_collectionend": 2_010_000,
        "object_texturestart": 2_180_009,
        "object_textureend": 2_280_009,
        "object_drawingstart": 2_280_010,
        "object_drawingend": 3_999_999,
        "object_customstart": 7_000_000,
        "object_customclassstart": 7_000_000,
        "object_customappstart": 7_001_000,
        "object_customappend": 7_999_999,
        "object_customscenestart": 8_000_000,
        "object_customsceneend": 9_999_999,
        "object_customend": 9_999_999,
        "object_variousstart": 10_000_000,
        **counted("appflavor", "lite edu pro"),
        **counted("objecttype", "detachedscript=117 drawingobject=124 customobject app scene"),
        **counted("propertytype", "start=0 color3=10 object=0xe0 objectarray objectmap"),
        **counted("propertyinfo", "retmethodsonly=0x200"),
        "sceneobject_path": 8,
        "modelproperty_not_showasinsidemodel": 0x0400,
        **counted("dynamicsimicon", "none objectisdynamicallysimulated"),
        "handleflag_handlemask": 0x003F_FFFF,
        "handleflag_flagmask": 0x0FC0_0000,
        "handleflag_camera": 0x0040_0000,
    }
)
"""The original's numbers; the server chooses its handles otherwise."""
