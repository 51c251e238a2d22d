"""One run of a program on a task.

rules.py    the calls that a program may make
stage.py    the process with the server: it records, and knows neither checks nor points
program.py  the process of the program within its walls
attempt.py  both together, until the run or the time is over
"""
