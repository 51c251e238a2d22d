"""Run the programs of examples/ros2 against a server."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from other_clients import client_folder, install_line
from processes import ROOT
from sdk_peer import NEEDED, SDK

from simx_client.protocol.cli.installing import line

WRAPPER = ROOT / "tests" / "support" / "programs" / "sdk_example.py"
EXAMPLES = ROOT / "examples" / "ros2"
TIMEOUT = 240.0


def start_example(port: int, name: str, *arguments: object) -> subprocess.Popen[str]:
    """Start a program; its standard output is a pipe. Skip the test without the SDK."""
    pytest.importorskip("rosbags", reason=line(["rosbags>=0.11,<0.12"]))
    folder = client_folder(SDK)
    if not folder.is_dir():
        pytest.skip(f"{SDK} is not installed: {install_line(SDK, *NEEDED)}")
    return subprocess.Popen(
        [sys.executable, str(WRAPPER), str(port), str(EXAMPLES / name), *map(str, arguments)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(folder)},
    )


def output_of(program: subprocess.Popen[str]) -> str:
    """Wait for the end of a program, and return what it printed."""
    try:
        return program.communicate(timeout=TIMEOUT)[0]
    finally:
        program.kill()


def run_example(port: int, name: str, *arguments: object) -> str:
    """Run a program to its end, and return what it printed."""
    return output_of(start_example(port, name, *arguments))
