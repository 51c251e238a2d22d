"""Images without OpenGL, by ray casting."""
