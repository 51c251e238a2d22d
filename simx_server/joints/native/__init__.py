"""The compiled form of the physics steps: one C file, which does what `stepping/` does in NumPy, with equal results."""
