"""A drop-in for ``vrep.py`` / ``sim.py``: every function and constant of the legacy remote API.

    import simx_client as vrep
    clientID = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)

Everything else of this package is behind this door and may move. How it is laid out: ``surface`` makes the
functions from the table in ``protocol``; ``connection`` is one client; ``modes`` says what the operation
modes mean; ``transport`` is the seam to the outside.
"""

from .protocol import constants as _constants
from .surface import functions as _functions

globals().update(_functions())
globals().update({name: value for name, value in vars(_constants).items() if not name.startswith("_")})

__all__ = sorted(  # pyright: ignore[reportUnsupportedDunderAll] - the stub file names them all
    name for name in globals() if name.lower().startswith(("sim_", "simx")) and name != "simx_client"
)
