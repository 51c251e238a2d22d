"""Properties with several values, by type."""

from __future__ import annotations

from typing import Any

from .base import PropertyPart
from .property_types import (
    COLOR,
    FLOAT_ARRAY,
    HANDLE_ARRAY,
    INT_ARRAY,
    INT_ARRAY2,
    POSE,
    QUATERNION,
    STRING_ARRAY,
    TABLE,
    VECTOR2,
    VECTOR3,
)


class TablePropertyFunctions(PropertyPart):
    """Functions for properties that are tables. Option `noError`: nil instead of an error.

    A function reads and sets the properties of all types that hold the same kind of values.
    """

    def getTableProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[Any] | dict[Any, Any] | None:
        """Return a property that is a table."""
        return self._read_property(TABLE, target, name, options)

    def setTableProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is a table."""
        self._write_property(TABLE, target, name, value, options)

    def getVector2Property(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[float] | None:
        """Return a property that is 2 numbers."""
        return self._read_property(VECTOR2, target, name, options)

    def setVector2Property(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is 2 numbers."""
        self._write_property(VECTOR2, target, name, value, options)

    def getVector3Property(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[float] | None:
        """Return a property that is x, y, z."""
        return self._read_property(VECTOR3, target, name, options)

    def setVector3Property(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is x, y, z."""
        self._write_property(VECTOR3, target, name, value, options)

    def getQuaternionProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[float] | None:
        """Return a property that is x, y, z, w."""
        return self._read_property(QUATERNION, target, name, options)

    def setQuaternionProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is x, y, z, w."""
        self._write_property(QUATERNION, target, name, value, options)

    def getPoseProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[float] | None:
        """Return a property that is x, y, z, then the quaternion x, y, z, w."""
        return self._read_property(POSE, target, name, options)

    def setPoseProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is x, y, z, then the quaternion x, y, z, w."""
        self._write_property(POSE, target, name, value, options)

    def getColorProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[float] | None:
        """Return a property that is red, green, blue, 0 to 1."""
        return self._read_property(COLOR, target, name, options)

    def setColorProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is red, green, blue, 0 to 1."""
        self._write_property(COLOR, target, name, value, options)

    def getIntArrayProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[int] | None:
        """Return a property that is integers."""
        return self._read_property(INT_ARRAY, target, name, options)

    def setIntArrayProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is integers."""
        self._write_property(INT_ARRAY, target, name, value, options)

    def getIntArray2Property(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[int] | None:
        """Return a property that is 2 integers."""
        return self._read_property(INT_ARRAY2, target, name, options)

    def setIntArray2Property(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is 2 integers."""
        self._write_property(INT_ARRAY2, target, name, value, options)

    def getFloatArrayProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[float] | None:
        """Return a property that is numbers."""
        return self._read_property(FLOAT_ARRAY, target, name, options)

    def setFloatArrayProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is numbers."""
        self._write_property(FLOAT_ARRAY, target, name, value, options)

    def getHandleArrayProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[int] | None:
        """Return a property that is handles."""
        return self._read_property(HANDLE_ARRAY, target, name, options)

    def setHandleArrayProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is handles."""
        self._write_property(HANDLE_ARRAY, target, name, value, options)

    def getStringArrayProperty(
        self, target: int, name: str, options: dict[str, Any] | None = None
    ) -> list[str] | None:
        """Return a property that is texts."""
        return self._read_property(STRING_ARRAY, target, name, options)

    def setStringArrayProperty(
        self, target: int, name: str, value: Any, options: dict[str, Any] | None = None
    ) -> None:
        """Set a property that is texts."""
        self._write_property(STRING_ARRAY, target, name, value, options)
