"""Edits that wait for a compile: a burst of them costs one, when something reads the model."""
