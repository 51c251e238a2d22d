"""Rendering with OpenGL: choosing a back end, and drawing with MuJoCo's renderer."""
