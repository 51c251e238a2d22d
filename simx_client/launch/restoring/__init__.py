"""Restore what newer versions of Python and its libraries removed, for old scripts."""
