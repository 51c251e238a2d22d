"""Pictures of a run for people: one picture of a scene, and a film of what runs. See docs/pictures-of-a-run.md.

`shot` is what a camera is asked for, `snapshot` writes one picture of it; `film` asks for one whenever a frame is due,
on the physics thread, and `film_file` encodes what comes of that, on a thread of its own.
"""

from .film import Film
from .shot import Shot
from .snapshot import Moment, write_snapshot

__all__ = ["Film", "Moment", "Shot", "write_snapshot"]
