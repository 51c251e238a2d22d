"""What client and server say to each other: one table of commands and the bytes they travel as.

Standard library and msgpack only. The server imports this package; this package imports neither half.

    commands.py   the table: every function once
    table/        its entries, and what arguments and results mean
    constants.py  every public constant of the legacy API
    kinds.py      which values an argument or a result can have, how they are coerced and checked
    messages.py   the two messages (calls out, replies back) and the greeting
    codec.py      messages to bytes and back
    keys.py       the Zenoh key expressions they travel on
"""
