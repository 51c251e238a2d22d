"""Write a scene that has everything within, such as a V-REP file, as a folder of MJCF, meshes, textures and scripts.

* `folder.py`: the folder as a whole
* `assets.py`: meshes as OBJ, textures as PNG, height fields in MuJoCo's binary form
* `asset_files.py`: the files that a scene names
* `scripts.py`: texts of scripts
* `tidying.py`: an MJCF text without what edits have left in it
* `file_names.py`: names of files
* `check.py`: whether the folder gives the same model
"""
