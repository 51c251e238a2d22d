"""Save the scene, or a model in it, as the bytes of a file.

* `packing.py`: all steps, from the world to the bytes
* `specs.py`: the spec that is saved, with the state of the model
* `notes.py`: its annotations, beyond those of the parts
"""
