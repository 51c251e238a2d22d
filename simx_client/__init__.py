"""Drop-in replacement for ``vrep.py`` and ``sim.py``: all functions and constants of the legacy remote API.

    import simx_client as vrep
    clientID = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)

New code may use `Client` instead: ``from simx_client import Client``, see `simx_client.client`. `Client` is not part of
the drop-in surface: it is missing from ``__all__`` and is loaded on first use. `simx_client.gym` has environments for
Gymnasium.

The other packages are private and may move:

    protocol      the table of functions, kinds, constants, messages: shared with the server
    legacy        the ``simx`` functions, made from the table; operation modes; marshalling
    connection    one client: order of calls, time-outs, liveness, discovery
    transport     messages to and from a server: Zenoh
    client        `Client`: objects, arrays and exceptions
    launch        ``simx-run``
    checking      ``simx-check``
    cli           ``simx call``, ``watch``, ``image``, ``list``, ``status``
"""

from typing import Any as _Any

from .legacy.functions import functions as _functions
from .protocol import constants as _constants

_FUNCTIONS = _functions()
globals().update(_FUNCTIONS)
globals().update({name: value for name, value in vars(_constants).items() if not name.startswith("_")})

__all__ = sorted(  # pyright: ignore[reportUnsupportedDunderAll] - the stub file names them all
    name for name in globals() if name.lower().startswith(("sim_", "simx")) and name != "simx_client"
)


def __getattr__(name: str) -> _Any:
    if name == "Client":
        from .client import Client

        return Client
    if name.startswith("c_"):
        from .legacy.c_functions import c_function

        if (function := c_function(name, _FUNCTIONS)) is not None:
            return function
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
