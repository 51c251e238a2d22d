"""What physics, sensors, scenes and edits cost."""
