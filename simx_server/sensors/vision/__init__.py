"""Vision sensors and the render thread."""
