"""Copies of objects: their elements, and the data that they share with their originals."""
