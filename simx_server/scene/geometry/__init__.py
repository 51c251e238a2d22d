"""Poses, frames, inertia and looks of objects."""
