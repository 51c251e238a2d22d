"""Handlers for objects: poses, parameters, properties, groups."""
