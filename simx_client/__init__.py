"""A drop-in for ``vrep.py`` / ``sim.py``: every function and constant of the legacy remote API.

    import simx_client as vrep
    clientID = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)

New code may take ``Client`` instead, see ``simx_client.client``: ``from simx_client import Client``. It is no part of the drop-in
surface, so it is neither in ``__all__`` nor loaded before somebody asks for it.

Everything else of this package is behind this door and may move. How it is laid out: ``surface`` makes the
functions from the table in ``protocol``; ``connection`` is one client; ``modes`` says what the operation
modes mean; ``transport`` is the seam to the outside.
"""

from typing import Any as _Any

from .legacy.functions import functions as _functions
from .protocol import constants as _constants

globals().update(_functions())
globals().update({name: value for name, value in vars(_constants).items() if not name.startswith("_")})

__all__ = sorted(  # pyright: ignore[reportUnsupportedDunderAll] - the stub file names them all
    name for name in globals() if name.lower().startswith(("sim_", "simx")) and name != "simx_client"
)


def __getattr__(name: str) -> _Any:
    if name == "Client":
        from .client import Client

        return Client
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
