"""Worlds of one process that step together in threads, for a program that has a client in each of them.

`crew` steps all of them; `member` is one of them; `operations` finds for a call what compiled code does instead. A step
can be made in three ways, with equal results bit for bit:

* `whole`: compiled code writes, makes the physics and reads, of all worlds in one call. Python's objects of such a
  world are out of date until its next turn (`Turns.lend`), which takes over what has happened.
* `shared`: Python makes what a world has beside physics, such as scripts; a thread makes the physics meanwhile.
* by `calls`, as without a crew: where something within the physics needs Python, or another client is there.
"""
