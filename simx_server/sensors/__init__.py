"""Simulated sensors: cameras and the render thread; proximity, force and contact sensors beside them.

Importing this package loads neither mujoco nor OpenGL; the modules load what they need.
"""
