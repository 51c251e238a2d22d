"""Meshes and images of a spec as files in memory, which MuJoCo processes once."""
