"""Properties with one value, by type."""

from __future__ import annotations

from typing import Any

from .base import PropertyPart
from .property_types import BOOL, BUFFER, FLOAT, HANDLE, INT, LONG, STRING


class SinglePropertyFunctions(PropertyPart):
    """Functions for properties with one value. Option `noError`: nil instead of an error.

    A function reads and sets the properties of all types that hold the same kind of values.
    """

    def getBoolProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> bool | None:
        """Return a property that is true or false."""
        return self._read_property(BOOL, target, name, options)

    def setBoolProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is true or false."""
        self._write_property(BOOL, target, name, value, options)

    def getIntProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> int | None:
        """Return a property that is an integer."""
        return self._read_property(INT, target, name, options)

    def setIntProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is an integer."""
        self._write_property(INT, target, name, value, options)

    def getLongProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> int | None:
        """Return a property that is an integer of 64 bits."""
        return self._read_property(LONG, target, name, options)

    def setLongProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is an integer of 64 bits."""
        self._write_property(LONG, target, name, value, options)

    def getFloatProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> float | None:
        """Return a property that is a number."""
        return self._read_property(FLOAT, target, name, options)

    def setFloatProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is a number."""
        self._write_property(FLOAT, target, name, value, options)

    def getStringProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> str | None:
        """Return a property that is text."""
        return self._read_property(STRING, target, name, options)

    def setStringProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is text."""
        self._write_property(STRING, target, name, value, options)

    def getBufferProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> bytes | None:
        """Return a property that is a string of bytes."""
        return self._read_property(BUFFER, target, name, options)

    def setBufferProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is a string of bytes."""
        self._write_property(BUFFER, target, name, value, options)

    def getHandleProperty(self, target: int, name: str, options: dict[str, Any] | None = None) -> int | None:
        """Return a property that is a handle."""
        return self._read_property(HANDLE, target, name, options)

    def setHandleProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is a handle."""
        self._write_property(HANDLE, target, name, value, options)
