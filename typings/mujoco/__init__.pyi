"""mujoco 4 ships no types: to the type checker everything in it is Any, so that it looks hard at our own code."""

from typing import Any

def __getattr__(name: str) -> Any: ...
