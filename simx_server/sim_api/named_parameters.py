"""Named parameters: texts that are stored in the server until it exits, read as other types too."""

from __future__ import annotations

import math

from simx_server.parts.custom_data import APPLICATION, NAMED
from simx_server.scripting.conversion.signature import to_text

from .base import ApiPart
from .effects import reads

_YES = ("true", "yes", "on")


class NamedParameterFunctions(ApiPart, effect="changes"):
    """Functions for named parameters. Reading an unknown one gives nil; '' removes one; a setter returns 1 for a new
    parameter, 0 for one that it replaces.
    """

    @reads
    def getNamedStringParam(self, name: str) -> bytes | None:
        """Return the value that a script of this server stored under a name; nil when there is none."""
        return self._world.custom_data.read(APPLICATION, f"{NAMED}{name}")

    def setNamedStringParam(self, name: str, value: bytes) -> int:
        """Store a value until the server exits; '' removes it."""
        is_new = self.getNamedStringParam(name) is None
        self._world.custom_data.write(APPLICATION, f"{NAMED}{name}", value)
        return int(is_new)

    @reads
    def getNamedBoolParam(self, name: str) -> bool | None:
        """Return whether the value is true, yes, on or a number other than 0."""
        text = self._text(name)
        return None if text is None else text.lower() in _YES or bool(_number(text) or 0)

    def setNamedBoolParam(self, name: str, value: bool) -> int:
        return self._write_text(name, "true" if value else "false")

    @reads
    def getNamedFloatParam(self, name: str) -> float | None:
        """Return the number; nil when the value is not a number."""
        text = self._text(name)
        return None if text is None else _number(text)

    def setNamedFloatParam(self, name: str, value: float) -> int:
        return self._write_text(name, repr(float(value)))

    @reads
    def getNamedInt32Param(self, name: str) -> int | None:
        """Return the whole number; nil when the value is not a whole number."""
        number = self.getNamedFloatParam(name)
        return int(number) if number is not None and number.is_integer() else None

    def setNamedInt32Param(self, name: str, value: int) -> int:
        return self._write_text(name, str(value))

    getStringNamedParam = getNamedStringParam
    setStringNamedParam = setNamedStringParam
    getSettingString = getNamedStringParam
    getSettingBool = getNamedBoolParam
    getSettingFloat = getNamedFloatParam
    getSettingInt32 = getNamedInt32Param

    def _text(self, name: str) -> str | None:
        value = self.getNamedStringParam(name)
        return None if value is None else to_text(value).strip()

    def _write_text(self, name: str, text: str) -> int:
        return self.setNamedStringParam(name, text.encode())


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None
