"""The local way in for clients of the same user on this host; see `simx_client.protocol.lane`.

gateway.py  the socket, its connections, and what arrives
link.py     what leaves: replies by the socket, values and images by shared memory
"""
