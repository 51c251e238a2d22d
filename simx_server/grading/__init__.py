"""``simx grade``: run programs of students on a task, and give points for what the simulation did.

task/      the file of a task: limits, rules, checks, random values; errors with line and valid values
checks/    the language of checks, evaluated in a replay of the recording
attempt/   one run of a program: the server, the program within its walls, the limits
referee.py replays a recording and decides the checks
reports.py the results for people, GitHub Classroom, Gradescope, nbgrader
grading.py all seeds of a task
command.py the command
"""
