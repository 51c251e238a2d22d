"""Save what was read from V-REP's files as such files: the changes are found by comparing two worlds.

* `document.py`: the file in the making
* `baseline.py`: a file as it was read, in another world
* `facts.py`: all facts of a world that such files know of
* `field.py`: one fact: how it is read in a world, and written into records
* `common.py`: the facts of all objects; `joints.py`, `shapes.py`, `dummies.py`, `sensors.py`, `paths.py`, `clouds.py`
* `objects.py`, `scripts.py`, `registered.py`, `settings.py`: the records of a file
"""
