"""Read and compile files of clients in a child process first, where they cannot do harm.

A scene of a few bytes can make MuJoCo recurse until its stack overflows, or allocate more memory than there is.
Therefore a file that a client sent, and an operator's file that names one, goes through a trial: a child with limits on
memory, processor time and wall time does the same work as the server later. A crash or a passed limit ends only the
child, and the client gets an error text. After a successful trial the server loads the very bytes that were tried.

* `gathering.py`: the files that a file consists of, their bytes, and circles among them
* `child.py`: the limits, and the trial itself
* `helper.py`: the process that forks a child for each trial, so that the child need not import MuJoCo first
* `pool.py`: one helper for each simultaneous trial
* `trials.py`: the server's side
"""
