"""Recordings: everything that was done for clients, in the order of the physics thread, and replays of it.

This order alone determines a simulation: simulation steps follow each other, and everything between two of them came
from a client or a script. So a recording contains the scene's files, every client's arrival and departure, its batches
of calls as they travelled, and every simulation step; their order reflects the decisions of the wall clock (when a
batch comes, when a step is due). Numbers computed from the state after every step show whether a replay is equal.

`log_file` is the file and `records` defines its content; `recorder` listens to the server loop, `state` computes the
numbers, `scene_files` finds the files of a scene. `replaying` replays an `opened` recording with a `replay_engine`. See
docs/recording.md.
"""

from .log_file import LogError
from .recorder import Recorder

__all__ = ["LogError", "Recorder"]
