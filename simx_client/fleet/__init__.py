"""``simx fleet``: servers on the hosts of a Ray cluster.

Ray places the servers, restarts them, and knows what runs where: each server is a process of a detached actor,
``member``. Zenoh carries the calls: all servers join one router, and clients find them by realm. ``cluster`` starts,
finds and ends a fleet; ``command`` is the command line. Needs the extra ``ray``, on every host.
"""
