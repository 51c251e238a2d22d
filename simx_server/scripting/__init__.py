"""The scene's own scripts: which there are, when they run, and what they may call.

`scripts.py` keeps them and finds who is meant (`targets.py`), `phases.py` says which lives and is called when,
`lives.py` begins, calls and ends one, `vision_call_backs.py` asks those that judge pictures. `interpreter.py` is the
border to a script's language: `lua.py` with its sandbox, watch, library and patterns, `python_interpreter.py`. `api/`
is the ``sim`` that scripts see, `namespaces.py` finds a function in it, `signature.py` turns script values into typed
arguments. `bodies.py` is for scripts of V-REP 3.
"""

from .scripts import Scripts

__all__ = ["Scripts"]
