"""The scene's own scripts: the list of them, and calls into them.

`scripts.py` stores them and finds the target of a call (`targets.py`), `phases.py` decides which one runs and when it
is called, `lives.py` starts, calls and ends one, `callbacks/` calls those that physics or cameras need.
`interpreter.py` is the interface to a script's language: `lua/` with its sandbox, watch, library and patterns, and
`python/`. The ``sim`` that scripts see is in `sim_api/`; `conversion/` makes typed arguments of their values.
`bodies.py` is for scripts of V-REP 3.
"""
