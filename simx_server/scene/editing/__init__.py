"""Changing a scene that is loaded: MjSpec is edited and compiled, and the state is carried over."""
