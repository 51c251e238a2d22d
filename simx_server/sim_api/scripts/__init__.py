"""Scripts of the scene: calls between them, their attributes and threads, and what a main script does."""
