"""Objects that exist in the scene and do nothing: the report names them."""

from __future__ import annotations

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import OtherObject

_LACKS = {
    "mill": "mills cut nothing",
    "mirror": "mirrors reflect nothing and clip nothing",
    "marker": "markers are not drawn",
    "custom": "custom objects of plug-ins have no effect",
}
"""Kinds of objects, and the sentence about what they lack."""


def report_inert(conversion: Conversion) -> None:
    """Name the objects without an effect."""
    for item in conversion.file.objects.values():
        if isinstance(item, OtherObject) and item.kind in _LACKS:
            conversion.report.leave_out(_LACKS[item.kind], conversion.name(item))
