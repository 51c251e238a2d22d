"""Compound shapes: several shapes become one, and one becomes several."""
