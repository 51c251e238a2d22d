"""Which threads Zenoh has, by the variable that it reads."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from processes import ROOT

from simx_client.protocol.zenoh import link

pytestmark = pytest.mark.slow

IMPORT = """
import os
from simx_client.protocol.zenoh import link
link.import_zenoh(link.SERVER_RUNTIME)
link.import_zenoh()
print(os.environ["ZENOH_RUNTIME"], end="")
"""


@pytest.mark.parametrize(
    ("inherited", "used"),
    [
        (None, link.SERVER_RUNTIME),
        (link.RUNTIME, link.SERVER_RUNTIME),
        ("(rx:(worker_threads:3))", "(rx:(worker_threads:3))"),
    ],
)
def test_a_server_has_its_own_also_when_a_client_started_it_unless_the_user_chose(
    inherited: str | None, used: str
) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "ZENOH_RUNTIME"}
    if inherited is not None:
        environment["ZENOH_RUNTIME"] = inherited
    done = subprocess.run(
        [sys.executable, "-c", IMPORT], env=environment, cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout == used
