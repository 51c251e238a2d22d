"""Meaning of names and expressions in a program's text."""
