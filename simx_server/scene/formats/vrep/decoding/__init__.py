"""Decode the records of each kind of object, and the other records of a file."""
