"""The lane for clients of the same user on this host; see `simx_client.protocol.lane`.

gateway.py  the socket, its connections, and clients that greet over Zenoh
handed.py   connections that are handed to one process through a socket, without Zenoh
peers.py    what arrives by the connections of both
link.py     what leaves: replies by the socket, values and images by shared memory; the choice between lane and Zenoh
"""
