"""V-REP 3's path objects, CoppeliaSim 4's paths as flat lists, and meshes along paths.

* `curve.py`: control points become Bezier points, with lengths along them
* `paths.py`: the path objects of the scene, their positions and what follows them
* `flat_paths.py`: a path as a list of numbers
* `sweep.py`: a mesh made of a section along a path
"""
