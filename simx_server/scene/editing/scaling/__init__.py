"""Scaling of objects: the geoms of shapes, and every length, mass and force of other objects."""
