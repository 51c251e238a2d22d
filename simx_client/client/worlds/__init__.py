"""Many simulations of one scene for one program, stepped together.

``worlds`` has the class; ``worker`` starts a process for some of the worlds and talks to it; ``process`` is what that
process does. Threads would not do: a controlled scene returns to Python after each physics step, some 20 us, and
Python's interpreter lock needs longer than that to change hands.
"""

from .worlds import Worlds

__all__ = ["Worlds"]
