"""The objects of a V-REP file as an MjSpec with annotations, which the loader prepares like any other scene.

* `context.py`: the conversion in progress, which all other modules extend
* `structure.py`: the bodies, and the body on which each object rides
* `shapes.py` and its neighbours: geometry, looks and contacts of shapes
"""
