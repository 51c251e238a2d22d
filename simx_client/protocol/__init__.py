"""The protocol between client and server: one table of commands and the bytes of their messages.

Uses the standard library and msgpack only. Client and server import this package; it imports neither of them.

    commands.py   the table: every function once
    table/        its entries, and what arguments and results mean
    constants.py  every public constant of the legacy API
    kinds.py      types of arguments and results: coercion and checks
    messages.py   the two messages (calls out, replies back) and the greeting
    codec.py      messages to bytes and back
    keys.py       the Zenoh key expressions of the messages
"""
