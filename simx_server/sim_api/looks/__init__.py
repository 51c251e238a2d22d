"""Functions for the looks of shapes."""
