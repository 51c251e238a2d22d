"""Data blocks, references and extension strings of the objects in a V-REP file; and its credits."""

from __future__ import annotations

from collections.abc import Mapping

from simx_server.scene.formats.annotations import UNTAGGED, WORLD
from simx_server.scene.formats.texts.values import encode_bytes
from simx_server.scene.formats.vrep.conversion.context import Conversion

MOST_NAMED = 1 << 22
"""Characters of all references together, which a small file with long names could make as many as memory holds."""


def add_custom_data(conversion: Conversion) -> None:
    """Annotate the data of all objects and of the scene; note the acknowledgements."""
    file = conversion.file
    conversion.report.credit(file.settings.acknowledgement)
    _add_blocks(conversion, WORLD, file.custom_data)
    left = MOST_NAMED
    for item in file.objects.values():
        name = conversion.name(item)
        conversion.report.credit(item.acknowledgement)
        _add_blocks(conversion, name, item.custom_data)
        for tag, handles in item.references.items():
            left -= sum(len(conversion.names.get(handle, "")) + 1 for handle in handles)
            if left < 0:
                conversion.report.leave_out("references whose names are too long together", name)
                break
            if handles:
                names = ",".join(conversion.names.get(handle, "") for handle in handles)
                conversion.annotate("references", name, **{tag or UNTAGGED: names})
        if item.extension:
            conversion.annotate("object", name, extension=item.extension)


def _add_blocks(conversion: Conversion, name: str, blocks: Mapping[str, bytes]) -> None:
    values = {tag: encode_bytes(data) for tag, data in blocks.items() if tag and data}
    if values:
        conversion.annotate("data", name, **values)
