"""The original's TCP protocol as a way in: unmodified programs with V-REP's own library connect here.

======================  ===========================================================================
`packets.py`            bytes of a socket to messages, and back
`messages.py`           messages to commands, and replies to messages
`forms.py`              payloads to arguments, and results to payloads
`translation.py`        a command to the call of the table, and a result to its reply
`containers.py`         commands that wait and replies to send: equal commands, streams, message ids
`splitting.py`          commands and replies in pieces
`connection.py`         one client: lock-step, time-outs, the server loop
`listener.py`           a port
======================  ===========================================================================
"""
