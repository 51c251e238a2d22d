"""Convex solids that collide in place of meshes.

* `solids.py`: which of the following a mesh gets
* `boxes.py`, `extrusions.py`: bodies of boxes, and outlines with a height, exactly
* `facets.py`, `prisms.py`: the surface as convex polygons, and thin solids behind them
* `simplifying.py`: meshes with fewer faces
* `decomposition.py`, `decomposing.py`, `part_cache.py`: convex parts by a library, in a process, kept on the disk
"""
