"""The user parameters of a V-REP file, which scripts read and write.

Since V-REP 3.6.1 revision 4 an object has them; in older files its child script has them, and replaces the object's.
"""

from __future__ import annotations

from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import UserParameter


def add_user_parameters(conversion: Conversion) -> None:
    """Annotate the parameters of all objects."""
    file = conversion.file
    for item in file.objects.values():
        _add(conversion, item.handle, item.parameters)
    for script in file.scripts:
        _add(
            conversion,
            script.object if script.object in conversion.names else script.owner,
            script.parameters,
        )


def _add(conversion: Conversion, handle: int, parameters: list[UserParameter]) -> None:
    values = {parameter: value for parameter, _, value in parameters if parameter}
    if handle in conversion.names:
        conversion.annotate("parameters", conversion.names[handle], **values)
