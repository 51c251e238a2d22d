"""CoppeliaSim's ZeroMQ remote API: a gateway for its official clients, which run unchanged.

`gateway.py` has the port; `peer.py` is a connection, and `zmtp.py` its bytes; `wire.py` reads and writes messages;
`clients.py` keeps the clients; `connection.py` answers the messages of one connection, with the namespaces that the
scene's scripts see (`calls.py`). All of it runs on the physics thread. cbor2 is the extra ``zmq``.
"""
