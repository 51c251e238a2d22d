"""Simulations of environments: where they run, and how they start episodes and make steps.

`episodes` makes the calls of each step; `together` has worlds of this process step in threads. `placing` decides
which of them a vector environment uses.
"""
