"""Images of a run for people: one image of a scene, and a film of a run. See docs/pictures-of-a-run.md.

`shot` defines the camera, `snapshot` writes one image of it; `film` requests one whenever a frame is due, on the
physics thread, and `film_file` encodes the images on a separate thread.
"""

from .film import Film
from .shot import Shot
from .snapshot import Moment, write_snapshot

__all__ = ["Film", "Moment", "Shot", "write_snapshot"]
