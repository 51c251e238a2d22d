"""Shapes and other objects that a script makes; colours, meshes and masses of shapes."""

from __future__ import annotations

from .base import ApiPart


class ShapeFunctions(ApiPart):
    """Metres, kilograms, colours 0..1."""
