"""Change a loaded scene: edit and compile its MjSpec, and carry the state over."""
