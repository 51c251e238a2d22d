"""Inertia, hulls, meshes and looks of objects."""
