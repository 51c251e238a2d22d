"""The entries of the table, a file per family; ``simx_client.protocol.commands`` puts them together.

command.py    what an entry can say
meanings.py   what arguments and results stand for
"""
