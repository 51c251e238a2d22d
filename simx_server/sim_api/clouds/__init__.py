"""Functions for point clouds and octrees."""
