"""The independent SDK's process, `tests/support/programs/sdk_node.py`, as a test uses it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from other_clients import client_folder, install_line
from processes import ROOT

from simx_client.protocol.cli.installing import line

PROGRAM = ROOT / "tests" / "support" / "programs" / "sdk_node.py"
SDK = "zenoh-ros2-sdk==0.1.8"
NEEDED = ("GitPython", "gitdb", "smmap", "tqdm", "json5")
"""The packages that the SDK imports, beside those of the extra dev."""

TIMEOUT = 60.0
"""Seconds until something that does not come fails the test."""


class SdkPeer:
    """Sends commands and collects messages."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self._changed = threading.Condition()
        self._messages: list[dict[str, Any]] = []
        self._answers: list[dict[str, Any]] = []
        self._has_ended = False
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for text in self._process.stdout:
            if not text.startswith("{"):
                continue  # the SDK prints too
            found = json.loads(text)
            with self._changed:
                (self._messages if "value" in found else self._answers).append(found)
                self._changed.notify_all()
        with self._changed:
            self._has_ended = True
            self._changed.notify_all()

    def do(self, command: str, *arguments: Any) -> Any:
        """Have a command executed, and return its answer."""
        self.begin(command, *arguments)
        return self.end()

    def begin(self, command: str, *arguments: Any) -> None:
        """Send a command."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps({command: arguments}) + "\n")
        self._process.stdin.flush()

    def end(self) -> Any:
        """Return the answer to a command that was sent."""
        with self._changed:
            assert self._changed.wait_for(lambda: self._answers or self._has_ended, TIMEOUT)
            assert self._answers, "the SDK's process has ended"
            answer = self._answers.pop(0)
        assert "failed" not in answer, answer
        return answer["done"]

    def next(self, topic: str, is_wanted: Callable[[Any], bool] = lambda _: True) -> Any:
        """Wait for a message of a topic, or a request of a service, and return it."""
        with self._changed:
            assert self._changed.wait_for(lambda: self._has(topic, is_wanted), TIMEOUT), topic
            return next(self._wanted(topic, is_wanted))

    def _has(self, topic: str, is_wanted: Callable[[Any], bool]) -> bool:
        return any(True for _ in self._wanted(topic, is_wanted))

    def _wanted(self, topic: str, is_wanted: Callable[[Any], bool]) -> Iterator[Any]:
        for each in self._messages:
            if each.get("topic", each.get("service")) == topic and is_wanted(each["value"]):
                yield each["value"]

    def close(self) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        try:
            self._process.wait(TIMEOUT)
        finally:
            self._process.kill()
            self._thread.join(TIMEOUT)
            self._process.stdout.close()


@contextmanager
def sdk_peer(port: int) -> Iterator[SdkPeer]:
    """Start the SDK as a peer of the router at a port of this machine."""
    pytest.importorskip("rosbags", reason=line(["rosbags>=0.11,<0.12"]))
    folder = client_folder(SDK)
    if not folder.is_dir():
        pytest.skip(f"{SDK} is not installed: {install_line(SDK, *NEEDED)}")
    process = subprocess.Popen(
        [sys.executable, str(PROGRAM), str(port)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(folder)},
    )
    peer = SdkPeer(process)
    try:
        yield peer
    finally:
        peer.close()
