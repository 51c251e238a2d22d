"""Write a scene that has everything within, such as a V-REP file, as a folder of MJCF, meshes, textures and scripts.

* `folder.py`: the folder as a whole
* `assets.py`: meshes as OBJ, textures as PNG, height fields in MuJoCo's binary form
* `scripts.py`: texts of scripts
* `file_names.py`: names of files
* `exact_numbers.py`: MuJoCo writes six digits; the MJCF gets all of them
* `check.py`: whether the folder gives the same model
"""
