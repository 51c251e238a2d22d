"""Collisions by V-REP's masks."""
