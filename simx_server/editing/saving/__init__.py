"""Save the scene, or a model in it, as the bytes of a file.

* `forms.py`: the files of a name, whose ending chooses their form
* `packing.py`: all steps, from the world to MJCF with its files
* `specs.py`: the spec that is saved, with the state of the model
* `notes.py`: its annotations, beyond those of the parts
"""
