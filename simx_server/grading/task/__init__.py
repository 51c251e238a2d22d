"""The file of a task, ``task.toml``.

reading.py   values of a TOML file with their lines, and errors that name both
random.py    the distributions of ``[randomize]``
task.py      the task
"""
