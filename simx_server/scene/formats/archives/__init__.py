"""Files that the server saves: `sim.saveScene` and `sim.saveModel`, read again by `sim.loadScene` and the like.

The form is the server's own, whatever the ending of the file's name: a ZIP archive whose first entry, `simx-saved.txt`,
is not compressed and says what the file is. V-REP and CoppeliaSim cannot open it. The other entries are those of a
folder that `--convert` writes: `model.xml`, an MJCF text with annotations, and the meshes, textures and scripts that it
names. Unpacked, it is therefore a scene like any other.

* `archive.py`: the archive itself
* `packing.py`: a spec as an archive
* `opening.py`: an archive as a spec
"""
