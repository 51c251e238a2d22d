"""The last minutes of a run: the world after each simulation step, and the calls of clients that belong to the step.

`moments` is the world of one step, saved and restored; `calls` notes what clients call; `history` keeps both within
bounds of time and memory; `going_on` starts a new run from a step. The web viewer's time slider and ``simx past`` use
it, see docs/view.md. Until a client asks for it, it costs a comparison per step.
"""

from .history import History, LogOfCalls
from .moments import Moment

__all__ = ["History", "LogOfCalls", "Moment"]
