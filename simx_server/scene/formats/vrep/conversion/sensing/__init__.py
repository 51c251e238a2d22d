"""Sensors, cameras and lights of a V-REP file, and what they look at."""
