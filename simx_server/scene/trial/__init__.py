"""Files of clients are read and compiled in a child process first, where they can do no harm.

A scene of a few bytes can make MuJoCo recurse until its stack is gone, or ask for more memory than there is. So a file
that a client sent, and a file of the operator's that names one, is tried: a child with limits on memory, processor time
and wall time does what the server is going to do with it. A crash or a passed limit ends the child alone, and the
client gets a sentence. What came through is loaded from the very bytes that were tried.

* `gathering.py`: which files a file is made of, their bytes, and circles among them
* `child.py`: the limits, and the trial itself
* `helper.py`: the process that forks a child for each trial, so that none imports MuJoCo first
* `pool.py`: as many of these as there are trials at a time
* `trials.py`: the server's side
"""
