"""Client and server of different protocols: each says so in a sentence, whichever of the two notices."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import ROOT, read_line, running

import simx_client as v
from simx_client.protocol.messages import PROTOCOL_VERSION
from simx_server.gateways import zenoh

SERVER = """
import logging, runpy, sys
logging.basicConfig(level=logging.WARNING)
import simx_server.gateways.zenoh as gateway
gateway.PROTOCOL_VERSION = {version}
if {notices_nothing}:
    gateway._version_refusal = lambda greeting: ""
sys.path.insert(0, "tests")
runpy.run_path("tests/plain_server.py", run_name="__main__")
"""


@pytest.fixture(autouse=True)
def no_connection_left() -> Iterator[None]:
    yield
    v.simxFinish(-1)


@pytest.mark.parametrize(("offset", "older"), [(-1, "server"), (1, "client")])
@pytest.mark.parametrize("notices_nothing", [False, True])
def test_another_protocol_is_told_on_both_sides(
    offset: int, older: str, notices_nothing: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    version = PROTOCOL_VERSION + offset
    program = SERVER.format(version=version, notices_nothing=notices_nothing)
    told = tmp_path / "log"
    with told.open("w") as log:
        command = [sys.executable, "-c", program]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=log, text=True, cwd=ROOT, bufsize=1
        )
        with running(process):
            port = int(read_line(process))
            assert v.simxStart("127.0.0.1", port, True, True, 5000, 5) == -1
    sentence = (
        f"client and server speak different protocols ({PROTOCOL_VERSION} and {version}); upgrade the {older}"
    )
    assert sentence in caplog.text
    if not notices_nothing:
        assert sentence in told.read_text()


def test_the_servers_sentence_names_the_side_to_upgrade() -> None:
    newer = zenoh.Greeting(PROTOCOL_VERSION + 1, "client", "name", 1)
    assert "upgrade the server" in zenoh._version_refusal(newer)
    assert "upgrade the client" in zenoh._version_refusal(newer._replace(protocol=PROTOCOL_VERSION - 1))
