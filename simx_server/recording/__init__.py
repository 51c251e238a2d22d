"""Recordings: all that was done for clients, in the order in which the physics thread did it, and replays of that.

Nothing but this order decides what a simulation does: passes follow each other, and what happens between two of them
came from a client or a script. So a recording has the scene's files, every client's coming and going, its batches of
calls as they travelled, and every pass; what the wall clock decides (when a batch comes, when a pass is due) is in
their order. Numbers made of the state, after every pass, tell whether a replay is the same.

`log_file` is the file and `records` what is in it; `recorder` hears what the engine does, `state` makes those numbers,
`scene_files` finds the files of a scene. `replaying` goes through an `opened` recording again, with a `replay_engine`.
See docs/recording.md.
"""

from .log_file import LogError
from .recorder import Recorder

__all__ = ["LogError", "Recorder"]
