"""Scene and model files: MJCF, URDF and V-REP's own become MuJoCo's spec, with annotations that complete it.

* `loader.py`: from a file to a scene; `specs.py`: which reader a file needs
* `urdf/`, `vrep/`: the readers of URDF and of V-REP's files
* `annotations/`, `texts/`: the `simx:` texts, and those of their values that are small languages
* `sources.py`, `contents.py`, `includes.py`: the files that a scene names
* `model_files.py`, `model_copies.py`, `mounting.py`, `surroundings.py`: what is put together from several files
* `saving.py`, `exporting/`: scenes as files
"""
