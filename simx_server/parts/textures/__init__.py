"""Textures of shapes: their numbers and pixels, and how scripts change them."""
