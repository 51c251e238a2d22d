"""The scene's own scripts: which there are, when they run, and what they may call.

`scripts.py` keeps and calls them, `lua.py` and `sandbox.py` are one sandboxed interpreter, `api/` is the ``sim``
that scripts see, `signature.py` turns script values into typed arguments.
"""

from .scripts import Scripts

__all__ = ["Scripts"]
