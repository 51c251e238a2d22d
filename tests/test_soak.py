"""Random calls from three clients for a while, some of which die: the server stays up and nothing grows."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

SECONDS = 20


@pytest.mark.timeout(120)
def test_random_calls_of_three_clients_leave_the_server_up_and_nothing_grows(
    record_property: Callable[[str, object], None],
) -> None:
    """`make soak` does the same for longer."""
    soak = Path(__file__).with_name("soak.py")
    found = subprocess.run([sys.executable, soak, str(SECONDS)], capture_output=True, text=True, check=False)
    record_property("figures", f"soak of {SECONDS} s: {found.stdout.splitlines()[-1]}")
    assert found.returncode == 0, found.stdout + found.stderr
