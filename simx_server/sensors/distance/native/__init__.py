"""The compiled form of the search for distances: one C file, which does what `triangle_pairs.py` does in NumPy."""
