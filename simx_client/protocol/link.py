"""The Zenoh options both ends agree on, each with the reason it was chosen.

The figures behind them: fewer thread hand-overs save a sixth of a round trip, a longer queue of data
batches a third of a picture's way, a short lease notices a frozen peer within two seconds.
"""

from __future__ import annotations

import json
import os
from typing import Any

RUNTIME = "(rx:(handover:app),acc:(handover:app),net:(handover:app),app:(worker_threads:1))"
"""Merge Zenoh's thread pools, but leave transmission its own thread: one thread for all can stall."""

LEASE_MS = 1_900
"""A peer that says nothing for so long is gone."""

OPEN_TIMEOUT_MS = 1_500
"""A port that accepts but does not speak Zenoh is given up after this time."""

COMMON: dict[str, Any] = {
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "transport/link/tx/lease": LEASE_MS,
    "transport/link/tx/queue/size/data": 16,
    "transport/unicast/open_timeout": OPEN_TIMEOUT_MS,
    "transport/unicast/accept_timeout": OPEN_TIMEOUT_MS,
}


def import_zenoh() -> Any:
    """Import Zenoh with the runtime above, unless the user chose another one by ``ZENOH_RUNTIME``.

    Zenoh reads the variable when its first session opens; importing it takes 40 ms, which a script that
    only packs floats need not pay.
    """
    os.environ.setdefault("ZENOH_RUNTIME", RUNTIME)
    import zenoh

    return zenoh


def configure(config: Any, options: dict[str, Any]) -> Any:
    """Write options (key path to plain value) into a Zenoh configuration."""
    for path, value in options.items():
        config.insert_json5(path, json.dumps(value))
    return config
