"""The Zenoh options both ends agree on, each with the reason it was chosen.

The figures behind them: fewer thread hand-overs save a sixth of a round trip, a longer queue of data
batches a third of a picture's way, a lease of seconds notices a frozen peer.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

WORKERS = 8
"""Threads of Zenoh's pool in a client. Closing the link of a peer that stopped reading with its queue full keeps one of
them for ten seconds, and with none left nobody is served; idle ones cost nothing that could be measured."""

SERVER_WORKERS = 64
"""The same in a server, where strangers choose how many links are closed: also a link that never finished its handshake
keeps a thread for 40 ms, until the other system acknowledges the end. 1500 of them held 8 threads up for seconds."""

READERS = 40
"""Threads of a server that read links. One waits for each link on which more arrives than is executed."""

RUNTIME = f"(rx:(handover:app),acc:(handover:app),net:(handover:app),app:(worker_threads:{WORKERS}))"
"""Merge Zenoh's thread pools, but leave transmission its own thread: with one pool for all, a large or
express message from inside a callback stalls, and what a script does in its callbacks is not ours to know."""

CONFIGURED_SERVER_RUNTIME = RUNTIME.replace(f":{WORKERS}", f":{SERVER_WORKERS}")
"""The same for a server with scouting or a configuration of the user's own."""

SERVER_RUNTIME = (
    f"(rx:(worker_threads:{READERS}),acc:(handover:app),tx:(handover:app),net:(handover:app),"
    f"app:(worker_threads:{SERVER_WORKERS}))"
)
"""One pool for everything else: less per round trip. A server may, as it batches, sends nothing express
and never answers from a callback; but not with scouting or a configuration of the user's own. The threads that read
have a pool of their own: what is to be done next by a thread that waits for a flooding link is not done meanwhile."""

_VARIABLE = "ZENOH_RUNTIME"

LEASE_MS = 4_000
"""A peer that says nothing for so long is gone. This is for frozen ones and cut cables: a process that ends, however
it ends, is noticed at once. Shorter, and a machine with much to do is taken for dead."""

FULL_QUEUE_US = 1_000_000
"""A peer that takes nothing out of a full queue for so long is cut off; until then whoever sends to it waits."""

OPEN_TIMEOUT_MS = 1_500
"""A port that accepts but does not speak Zenoh is given up after this time."""

COMMON: dict[str, Any] = {
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "transport/link/tx/lease": LEASE_MS,
    "transport/link/tx/queue/size/data": 16,
    "transport/link/tx/queue/congestion_control/block/wait_before_close": FULL_QUEUE_US,
    "transport/unicast/open_timeout": OPEN_TIMEOUT_MS,
    "transport/unicast/accept_timeout": OPEN_TIMEOUT_MS,
}

CLIENT: dict[str, Any] = {
    **COMMON,
    # Else each client keeps 16 MB of shared memory for what it sends, and a server that takes it, as its operator may
    # choose, never lets go of it. Pictures can come through the server's own all the same, which is one for all.
    "transport/shared_memory/transport_optimization/enabled": False,
}

SERVER: dict[str, Any] = {
    **COMMON,
    # What a peer sends through shared memory stays mapped here for good, 16 MB and two descriptors for each that there
    # ever was: Zenoh 1.10 keeps all segments it has read. It would bring a picture of 640x480 0.3 ms sooner.
    "transport/shared_memory": {"enabled": False},
    # More connections than descriptors may be waiting to say something; a newcomer is not refused for them.
    "transport/unicast/accept_pending": 100_000,
}

TO_ROUTERS: dict[str, Any] = {
    # A server begins without its routers, and finds them when they come.
    "connect/timeout_ms": -1,
    "connect/exit_on_failure": False,
    "connect/retry": {"period_init_ms": 100, "period_max_ms": 2_000, "period_increase_factor": 1.5},
    # Else opening waits half a second, for peers that nobody looks for.
    "open/return_conditions/connect_scouted": False,
}


def import_zenoh(runtime: str = RUNTIME) -> Any:
    """Import Zenoh with one of the runtimes above, unless the user chose another one by ``ZENOH_RUNTIME``.

    Zenoh reads the variable when the first session of the process opens. A script that only packs floats
    need not load it at all.
    """
    chosen = os.environ.get(_VARIABLE, runtime)
    # A server that a client has started inherits the client's, with which floods would hold everybody up.
    is_inherited = (
        chosen in (RUNTIME, SERVER_RUNTIME, CONFIGURED_SERVER_RUNTIME) and "zenoh" not in sys.modules
    )
    os.environ[_VARIABLE] = runtime if is_inherited else chosen
    import zenoh

    return zenoh


def configure(config: Any, options: Mapping[str, Any]) -> Any:
    """Write options (key path to plain value) into a Zenoh configuration."""
    for path, value in options.items():
        config.insert_json5(path, json.dumps(value))
    return config


def configured_by(zenoh: Any, file: Path, defaults: Mapping[str, Any]) -> Any:
    """The user's own Zenoh configuration; `defaults` take the place of what it leaves as Zenoh has it.

    Raises:
        zenoh.ZError: the file cannot be read.
    """
    config, untouched = zenoh.Config.from_file(str(file)), zenoh.Config()
    return configure(
        config,
        {
            path: value
            for path, value in defaults.items()
            if config.get_json(path) == untouched.get_json(path)
        },
    )


def reason(error: Exception) -> str:
    """What Zenoh said, in one line: without the places in its own source, and without a copy of the file."""
    text = re.sub(r"\s+at \S+\.rs:\d+\.?", "", str(error)).strip()
    place = re.match(r"--> (\d+):(\d+)", text)
    last = text.splitlines()[-1].strip(" =") if text else type(error).__name__
    return f"line {place[1]}, column {place[2]}: {last}" if place else last
