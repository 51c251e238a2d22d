"""One run of a program on a task.

rules.py    the calls that a program may make
stage.py    the process with the server: it records, and knows neither checks nor points
attempt.py  that process and the program within its walls (`simx_server/confined`), until the run or the time is over
"""
