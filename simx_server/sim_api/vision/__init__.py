"""Vision sensors and their images."""
