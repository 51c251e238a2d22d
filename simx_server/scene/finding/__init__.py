"""Find scene and model files, and check what they reference."""
