"""Checks of a task: expressions on names of the scene, evaluated on the server's side after each simulation step.

expression.py  the language: a fixed list of functions, parsed by Python's own parser and never executed by it
sight.py       the functions: what they read of the world
timing.py      when an expression has to be true
"""
