"""Raw Zenoh peers at a real server: more of them by ``python tests/fuzz/run.py peers CASES``."""

from __future__ import annotations

from pathlib import Path

import pytest
from fuzz import peers

pytestmark = [pytest.mark.slow, pytest.mark.system, pytest.mark.gl]

CASES = 600


def test_raw_peers_disturb_no_client(tmp_path: Path) -> None:
    peers.run(CASES, 1, tmp_path)
