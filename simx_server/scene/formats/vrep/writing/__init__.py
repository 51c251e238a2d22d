"""Write V-REP's files: change records of a file that was read, and keep the bytes of all others.

* `record_lists.py`: a list of records that can be changed
* `object_records.py`: the records of one object
* `top_level.py`: the records of a file, and its header
* `script_texts.py`: the masked text of a script
* `leaves.py`, `meshes.py`, `colors.py`: the geometry of a shape
* `clouds.py`: octrees and point clouds
"""
