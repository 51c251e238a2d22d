"""Client and server of different protocols: each says so in a sentence, whichever of the two notices."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from forked import Forked
from processes import read_line, running

import simx_client as v
from simx_client.protocol.messages import PROTOCOL_VERSION

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_connection_left")]

SERVER = """
import logging, runpy, sys
logging.basicConfig(level=logging.WARNING)
import simx_server.gateways.zenoh.gateway as gateway
gateway.OLDEST_PROTOCOL = gateway.PROTOCOL_VERSION = {version}
if {notices_nothing}:
    gateway.choose_version = lambda *spoken: {version}
sys.path.insert(0, "tests/support/worlds")
runpy.run_path("tests/support/worlds/plain_server.py", run_name="__main__")
"""


@pytest.mark.parametrize(("offset", "older"), [(-1, "server"), (1, "client")])
@pytest.mark.parametrize("notices_nothing", [False, True])
def test_another_protocol_is_told_on_both_sides(
    offset: int, older: str, notices_nothing: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    version = PROTOCOL_VERSION + offset
    program = SERVER.format(version=version, notices_nothing=notices_nothing)
    told = tmp_path / "log"
    with (
        told.open("w") as log,
        running(Forked(("-c", program), stdout=subprocess.PIPE, stderr=log)) as process,
    ):
        port = int(read_line(process))
        assert v.simxStart("127.0.0.1", port, True, True, 5000, 5) == -1
    sentence = (
        f"client and server share no version of the protocol (the client speaks {PROTOCOL_VERSION}, "
        f"the server {version}); upgrade the {older}"
    )
    assert sentence in caplog.text
    if not notices_nothing:
        assert sentence in told.read_text()
