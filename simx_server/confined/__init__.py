"""Programs of others, such as students, within walls of the kernel: ``simx grade`` and the editor of a class.

program.py  the process of a program, with its limits and its output
folder.py   its folder: how much is in it, and its end
walls.py    what this system lacks for that
"""
