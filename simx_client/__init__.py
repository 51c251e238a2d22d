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

_PREFIXES = ("sim_", "simx")


def _fill() -> dict[str, _Any]:
    """Put every function and constant here, and return them by name.

    The first use of one does this, not the import: the server and the programs of the command line import packages of
    this one, and most of them need none of these.
    """
    from .legacy.functions import FUNCTIONS
    from .protocol import constants

    surface = FUNCTIONS | {name: value for name, value in vars(constants).items() if not name.startswith("_")}
    known = globals()  # a program may have replaced a function before the first use of one
    known.update(
        {name: value for name, value in surface.items() if name not in known}, __all__=sorted(surface)
    )
    return surface


def __getattr__(name: str) -> _Any:
    if name == "Client":
        from .client import Client

        return Client
    if name == "__all__" or name.lower().startswith(_PREFIXES):
        surface = _fill()
        if name == "__all__":
            return sorted(surface)
        if name in surface:
            return surface[name]
    elif name.startswith("c_"):
        from .legacy.c_functions import c_function
        from .legacy.functions import FUNCTIONS

        if (function := c_function(name, FUNCTIONS)) is not None:
            return function
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    _fill()
    return list(globals())
