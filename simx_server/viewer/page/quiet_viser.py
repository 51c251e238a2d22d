"""viser's server as the page wants it: on a port of this host that the system chooses, and silent."""

from __future__ import annotations

import contextlib
import io
import socket

import viser


def open_browser_server() -> viser.ViserServer:
    """One that only the gate is to know."""
    with socket.socket() as claimed:
        # viser tries the ports after a taken one by itself, so nothing is lost if another takes this one now.
        claimed.bind(("127.0.0.1", 0))
        port = int(claimed.getsockname()[1])
    # It tells its own address even when it is not to be verbose; stdout is for the page's.
    with contextlib.redirect_stdout(io.StringIO()):
        return viser.ViserServer(host="127.0.0.1", port=port, verbose=False)
