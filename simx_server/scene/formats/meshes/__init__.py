"""Mesh files with their colours: COLLADA, PLY, and those STL files that MuJoCo does not read.

* `parts.py`: a mesh as parts, one for each material
* `collada.py`: COLLADA files, by the library pycollada
* `polygons.py`: PLY and STL files, by the library trimesh
* `obj_materials.py`: materials of OBJ files
* `naming.py`: the files that a mesh file names
* `reading.py`: a mesh file as parts, whatever its format
"""
