"""Find the server's package and start a server in this process.

The client does not depend on the server: an entry point of the installed server leads to the function that starts one.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import cast

from simx_client.errors import ConnectionFailed
from simx_client.protocol.messages import Pace
from simx_client.transport.direct import DirectTransport, EmbeddedServer
from simx_client.transport.zenoh_session import client_name, program_name

from .clients import CLIENTS
from .embedded import EmbeddedConnection

VARIABLE = "SIMX_EMBED"
"""Scene and flags of ``simx-server``, as in a shell: all connections of this process lead to a server in it."""

_GROUP = "simx.embedding"


def start_server(arguments: Sequence[str]) -> EmbeddedServer:
    """Start a server in this process.

    Args:
        arguments: those of ``simx-server``: a scene and flags.

    Raises:
        ConnectionFailed: the server is not installed, or it refuses the scene or a flag.
    """
    # Few scripts need these, which take 20 ms.
    from importlib import metadata

    from simx_client.protocol.cli.installing import missing_server

    if missing := missing_server():
        raise ConnectionFailed(missing)
    for found in metadata.entry_points(group=_GROUP):
        start = cast(Callable[[Sequence[str]], EmbeddedServer], found.load())
        return start(arguments)
    raise ConnectionFailed(
        "the installed simx-server is older than this client and cannot be embedded; install it again"
    )


def chosen_scene() -> list[str] | None:
    """Return the arguments in the variable; None if it is not set.

    Raises:
        ValueError: it cannot be read.
    """
    text = os.environ.get(VARIABLE, "").strip()
    if not text:
        return None
    import shlex  # few scripts need it

    try:
        return shlex.split(text)
    except ValueError as error:
        raise ValueError(f"{VARIABLE}: {text!r} cannot be read: {error}") from None


def embedded_in_process(
    arguments: Sequence[str], address: str, port: int, *, timeout: float, pace: Pace
) -> EmbeddedConnection:
    """Return a connection, not made yet, to the one server of this process that simxStart leads to.

    Args:
        arguments: those of ``simx-server``, if it has to be started.
        address: the address and port in the script, which have no further effect.
        timeout: time-out of blocking calls in seconds.
        pace: pace of the blocking functions.
    """

    def opened() -> DirectTransport:
        server = CLIENTS.server_in_process(lambda: start_server(arguments))
        return server.connect(client_name(), program_name(), port)

    return EmbeddedConnection(opened, where=f"{address}:{port}", timeout=timeout, pace=pace)


def as_arguments(scene: str | os.PathLike[str] | None, settings: dict[str, object]) -> list[str]:
    """Return the arguments of ``simx-server`` for keywords: ``time_step=0.01`` is ``--time-step 0.01``.

    True and False stand for a flag and its opposite, a list for a flag that is repeated.
    """
    arguments = [] if scene is None else [os.fspath(scene)]
    for name, value in settings.items():
        flag = name.replace("_", "-")
        if value is None or value is False:
            arguments += [] if value is None else [f"--no-{flag}"]
        elif value is True:
            arguments.append(f"--{flag}")
        else:
            several = cast("Sequence[object]", value) if isinstance(value, (list, tuple)) else [value]
            for each in several:
                arguments += [f"--{flag}", _text(each)]
    return arguments


def _text(value: object) -> str:
    return "max" if value == float("inf") else str(value)
