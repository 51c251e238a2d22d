"""viser's server as the page wants it: where only the gate finds it, and silent."""

from __future__ import annotations

import contextlib
import io
import secrets
import socket

import viser


def open_browser_server() -> viser.ViserServer:
    """One that only the gate is to know: viser lets in whoever comes, web sites in this machine's browsers too.

    These can try all ports of 127.0.0.1 in turn, but not all addresses of loopback; where there is only one
    (on other systems than Linux), the port is all that is hidden.
    """
    for host in (
        f"127.{'.'.join(str(each) for each in secrets.token_bytes(2))}.{1 + secrets.randbelow(254)}",
        "127.0.0.1",
    ):
        with socket.socket() as claimed, contextlib.suppress(OSError):
            # viser tries the ports after a taken one by itself, so nothing is lost if another takes this one now.
            claimed.bind((host, 0))
            port = int(claimed.getsockname()[1])
            break
    else:
        raise OSError("no port of this machine is free")
    # It tells its own address even when it is not to be verbose; stdout is for the page's.
    with contextlib.redirect_stdout(io.StringIO()):
        return viser.ViserServer(host=host, port=port, verbose=False)
