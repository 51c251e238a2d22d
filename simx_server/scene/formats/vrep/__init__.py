"""Open V-REP's and CoppeliaSim's own files: `.ttt` scenes and `.ttm` models.

The bytes become a tree of plain objects, and the tree becomes MJCF with annotations, like any other scene:

* `recognising.py`: whether a file is one of V-REP's
* `opening.py`: all of the following
* `container.py`, `huffman.py`: the header, and the compression
* `records.py`: the list of all records: their tags, and the fields in them
* `chunks.py`: the records in the body, which lie in lists within lists
* `reading.py`, `decoding/`: bytes to the plain objects of `objects/`
* `converting.py`, `conversion/`: the objects to an MjSpec
* `report.py`: what a conversion approximated or left out

The format is described in `docs/internals/vrep-files.md`; it was found by examining files.
"""
