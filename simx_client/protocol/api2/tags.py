"""Numbers of the CBOR tags in API 2's messages: the original's own, and those of RFC 8746 for matrices and arrays."""

from __future__ import annotations

COLOR, QUATERNION, POSE = 4294970000, 4294980000, 4294980500
FUNCTION, OBJECTS, OBJECT = 4294999997, 4294999998, 4294999999
MATRIX = 40

ARRAYS = {64: "B", 69: "H", 70: "I", 71: "Q", 72: "b", 77: "h", 78: "i", 79: "q", 85: "f", 86: "d"}
"""Tags of arrays of numbers, little-endian, and their letters in Python's module array and in NumPy."""
