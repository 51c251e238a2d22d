"""The editor of a class: a program in the browser, run on the teacher's machine within walls of the kernel.

plan.py         settings of the editor, and the texts of their flags
component.py    Monaco's files, of the extra ``editor``
text.py         the text of a seat's program, in memory and in a file
output.py       what a program writes, in bounds, and the line of an error
run.py          one run of a program
seat_editor.py  the editor of a seat: text, run and output together
views.py        the 3-D views of the seats: started for a browser, ended some time after it has left
nursery.py      the process that forks the views, so that they share their memory
"""
