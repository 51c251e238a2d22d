"""What client and server say to each other: one table of commands and the bytes they travel as.

Standard library and msgpack only. The server imports this package; this package imports neither half.

    commands.py   the table: every function, its arguments, results, identity
    constants.py  every public constant of the legacy API
    kinds.py      what an argument or a result may be, how it is coerced and checked
    messages.py   the two messages (calls out, replies back) and the greeting
    codec.py      messages to bytes and back
    keys.py       the Zenoh key expressions they travel on
"""
