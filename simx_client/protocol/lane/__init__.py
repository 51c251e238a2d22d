"""The lane: a UNIX socket and shared memory between a client and a server of one user on one host.

The client's thread and the physics thread use the socket themselves, so a call needs no other thread. A large answer
comes as a file in memory, not in parts. The newest values of streams are in shared memory, which holds no backlog and
is read without a system call. Zenoh keeps everything else: discovery, greetings, liveliness, and all messages between
hosts.

    offer.py    the name of the socket, as the welcome has it, and the user at its other end
    frames.py   messages on the socket
    memory.py   a newest message in shared memory
"""
