"""Proximity sensors: their volumes, and the nearest point detected within them."""
