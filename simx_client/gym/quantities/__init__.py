"""Quantities of a scene by name: how each is read and set, and the objects that they belong to."""
