"""Zenoh options of client and server, each with its reason.

Measured effects: fewer thread hand-overs save a sixth of a round trip, a longer queue of data batches a third
of an image's transfer; a lease of seconds detects a frozen peer.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from simx_client.protocol.codec import MAX_BATCH

WORKERS = 8
"""Threads of Zenoh's pool in a client. Closing the link of a peer that stopped reading with a full queue
keeps one of them busy for ten seconds, unless `connections.close_at_once` has prevented it; without a free one
no client is served. Idle threads have no measurable cost."""

SERVER_WORKERS = 64
"""The same in a server, where clients determine how many links are closed: a link that never finished its
handshake also keeps a thread busy for 40 ms, until the other system acknowledges the end. 1500 of them
blocked 8 threads for seconds."""

READERS = 40
"""Threads of a server that read links. One waits for each link on which more arrives than is executed."""

RUNTIME = f"(rx:(handover:app),acc:(handover:app),net:(handover:app),app:(worker_threads:{WORKERS}))"
"""Merge Zenoh's thread pools, but keep a separate thread for transmission: with one pool for all, a large or
express message from inside a callback stalls, and scripts may send any message from their callbacks."""

CONFIGURED_SERVER_RUNTIME = RUNTIME.replace(f":{WORKERS}", f":{SERVER_WORKERS}")
"""The same for a server with scouting or a configuration file of the user."""

SERVER_RUNTIME = (
    f"(rx:(worker_threads:{READERS}),acc:(handover:app),tx:(handover:app),net:(handover:app),"
    f"app:(worker_threads:{SERVER_WORKERS}))"
)
"""One pool for everything else: shorter round trips. This works for a server that batches, sends nothing
express and never answers from a callback, but not with scouting or a configuration file of the user. The
reading threads have a separate pool: the next task of a thread that waits for a flooding link is delayed."""

_VARIABLE = "ZENOH_RUNTIME"

LEASE_MS = 4_000
"""Lease in milliseconds: a peer silent for this time counts as lost. It detects frozen peers and cut cables;
the end of a process is detected at once. With a shorter lease, a machine under load counts as lost."""

FULL_QUEUE_US = 1_000_000
"""Time in microseconds after which a peer that reads nothing from a full queue is disconnected; until then
senders wait."""

OPEN_TIMEOUT_MS = 1_500
"""Time-out in milliseconds for a port that accepts but does not speak Zenoh."""

MARGIN = 1 << 16
"""Bytes of a message that Zenoh adds to a batch: its key, its attachment, its own fields."""

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
    # Otherwise each client allocates 16 MB of shared memory for its messages, which a server that accepts it,
    # as its operator may choose, never frees. Images can still use the server's shared memory, which all
    # clients share.
    "transport/shared_memory/transport_optimization/enabled": False,
}

MOST_PENDING = 100_000
"""Connections that may wait for their first message: more than there are descriptors, so that a new one is not refused
because of them. Zenoh's default is 100."""

SERVER: dict[str, Any] = {
    **COMMON,
    # Shared memory of a peer stays mapped here for good, 16 MB and two descriptors for each peer that ever
    # existed: Zenoh 1.10 keeps all segments it has read. It would save 0.3 ms for an image of 640x480.
    "transport/shared_memory": {"enabled": False},
    # Zenoh keeps the pieces of a message until the last one comes, also those of a stranger: up to a gigabyte
    # for each of the eight priorities, with its defaults. Nothing here sends with another priority than the
    # usual one, so one of them does.
    "transport/link/rx/max_message_size": MAX_BATCH + MARGIN,
    "transport/unicast/qos/enabled": False,
    "transport/unicast/accept_pending": MOST_PENDING,
}

TO_ROUTERS: dict[str, Any] = {
    # A server starts without its routers, and connects when they are available.
    "connect/timeout_ms": -1,
    "connect/exit_on_failure": False,
    "connect/retry": {"period_init_ms": 100, "period_max_ms": 2_000, "period_increase_factor": 1.5},
    # Otherwise opening waits half a second for peers, which are not used.
    "open/return_conditions/connect_scouted": False,
}


def import_zenoh(runtime: str = RUNTIME) -> Any:
    """Import Zenoh with one of the runtimes above, unless the user chose another one by ``ZENOH_RUNTIME``.

    Zenoh reads the variable when the first session of the process opens. A script that only packs floats does
    not load it.
    """
    chosen = os.environ.get(_VARIABLE, runtime)
    # A server that a client has started inherits the client's value, with which a flood would block all
    # clients.
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
    """Load the user's Zenoh configuration; `defaults` replace values that it leaves at Zenoh's defaults.

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
    """Return Zenoh's error in one line, without positions in its source and without a copy of the file."""
    text = re.sub(r"\s+at \S+\.rs:\d+\.?", "", str(error)).strip()
    place = re.match(r"--> (\d+):(\d+)", text)
    last = text.splitlines()[-1].strip(" =") if text else type(error).__name__
    return f"line {place[1]}, column {place[2]}: {last}" if place else last
