"""Collision and distance between objects."""
