"""The compiled form of the first hit of a ray: one C file, which does what `first_hit.py` does in Python."""
