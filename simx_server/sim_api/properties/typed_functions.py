"""The functions for properties of one type, ``sim.getFloatProperty`` and its like: two for each type."""

from __future__ import annotations

from . import property_types as t
from .base import PropertyPart


class SinglePropertyFunctions(
    PropertyPart, effect="changes", types=(t.BOOL, t.INT, t.LONG, t.FLOAT, t.STRING, t.BUFFER, t.HANDLE)
):
    """Functions for properties with one value. Option `noError`: nil instead of an error.

    A function reads and sets the properties of all types that hold the same kind of values.
    """


class TablePropertyFunctions(
    PropertyPart,
    effect="changes",
    types=(
        *(t.TABLE, t.VECTOR2, t.VECTOR3, t.QUATERNION, t.POSE, t.COLOR, t.MATRIX),
        *(t.INT_ARRAY, t.INT_ARRAY2, t.FLOAT_ARRAY, t.HANDLE_ARRAY, t.STRING_ARRAY),
    ),
):
    """Functions for properties that are tables. Option `noError`: nil instead of an error.

    A function reads and sets the properties of all types that hold the same kind of values.
    """
