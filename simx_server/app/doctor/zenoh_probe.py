"""Send a query from one Zenoh session of this machine to another, and print JSON. Runs as a child process."""

from __future__ import annotations

import json
import socket
import sys
import time
from typing import Any

from simx_client.protocol.zenoh import link

KEY = "simx/doctor"
QUESTIONS = 20
TIMEOUT = 5.0
"""Time-out in seconds for one answer."""


def main() -> int:
    """Print the result; return exit status 1 with a reason on stderr when no answer comes."""
    zenoh: Any = link.import_zenoh()
    with socket.socket() as place:  # a free port: the system does not assign it again in the next moments
        place.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{place.getsockname()[1]}"
    ends = (
        {**link.SERVER, "mode": "peer", "listen/endpoints": [endpoint]},
        {"mode": "client", "connect/endpoints": [endpoint], "transport/shared_memory/enabled": False},
    )
    try:
        with (
            zenoh.open(link.configure(zenoh.Config(), ends[0])) as answering,
            zenoh.open(link.configure(zenoh.Config(), {**link.CLIENT, **ends[1]})) as asking,
        ):
            queryable = answering.declare_queryable(KEY, _answer)
            times = [_ask(asking) for _ in range(QUESTIONS)]
            queryable.undeclare()
    except (zenoh.ZError, TimeoutError) as error:
        sys.stderr.write(f"{link.reason(error)}\n")
        return 1
    sys.stdout.write(json.dumps({"milliseconds": 1000 * min(times)}) + "\n")
    return 0


def _answer(query: Any) -> None:
    query.reply(KEY, b"here")


def _ask(session: Any) -> float:
    """Return the seconds of one query and its answer. Raises TimeoutError."""
    deadline = time.monotonic() + TIMEOUT
    while time.monotonic() < deadline:  # until the two have found each other
        began = time.perf_counter()
        if any(reply.ok is not None for reply in session.get(KEY, timeout=TIMEOUT)):
            return time.perf_counter() - began
        time.sleep(0.01)
    raise TimeoutError(f"no answer within {TIMEOUT:g} s")


if __name__ == "__main__":
    sys.exit(main())
