"""CoppeliaSim's ZeroMQ remote API: a gateway for its official clients, which run unchanged.

`gateway.py` has the socket; `peers.py` knows which connections are open; `wire.py` reads and writes messages;
`clients.py` keeps the clients; `connection.py` answers the messages of one connection, with the namespaces that the
scene's scripts see (`calls.py`). All of it runs on the physics thread. pyzmq and cbor2 are the extra ``zmq``.
"""
