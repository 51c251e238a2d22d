"""Poses of objects: read, set and convert them."""
