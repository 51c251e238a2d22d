"""CoppeliaSim 4.11's object model, its API 2: classes with properties and methods, over the functions of API 1.

A program calls a method of an object by name: `dispatch.py` finds it, by the class of the object (`classes.py`), in
`methods/`. Properties are those of API 1 under their new names and types (`tables/`). `values.py` has the values that
API 1 does not know: objects, matrices, poses, quaternions, colours.
"""
