"""Eight clients for a while, some of which die: the server stays up and everything returns to its first state."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.gl]

TESTS = Path(__file__).parents[2]
SECONDS = 4


@pytest.mark.timeout(240)
def test_eight_clients_that_call_step_edit_and_die_leave_the_server_as_it_was(
    record_property: Callable[[str, object], None],
) -> None:
    """`make soak` does the same for longer."""
    soak = Path(__file__).with_name("soak.py")
    path = os.pathsep.join(
        str(TESTS / folder) for folder in ("", "support", "support/worlds", "support/gateways")
    )
    environment = os.environ | {"PYTHONPATH": path}
    found = subprocess.run(
        [sys.executable, soak, str(SECONDS)], env=environment, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stdout + found.stderr
    record_property("figures", f"soak of {SECONDS} s: {found.stdout.splitlines()[-1]}")
