"""Transport of messages between a connection and a server, implemented over Zenoh."""
