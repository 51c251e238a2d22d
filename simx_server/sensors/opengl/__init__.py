"""Rendering with OpenGL: choose a back end, and draw with MuJoCo's renderer."""
