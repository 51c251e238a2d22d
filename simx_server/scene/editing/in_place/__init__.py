"""Edits that are made in the compiled model itself, because physics does not notice them: dummies and still shapes."""
