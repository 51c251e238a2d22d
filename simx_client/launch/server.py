"""A simx-server of the script's own: started before it, ready before the script begins, stopped after it."""

from __future__ import annotations

import logging
import os
import re
import subprocess
import sys
import threading
from collections.abc import Sequence
from typing import IO

from simx_client.errors import SimxError
from simx_client.redirect import VARIABLE, format_redirects
from simx_client.session import CONFIG_VARIABLE

logger = logging.getLogger(__name__)

USUAL_PORTS = (19997, 19999)
"""What old scripts have written in them."""

STOP_WITHIN_S = 5.0  # the server promises two seconds after SIGTERM


class ServerNotReady(SimxError):
    """The server ended, or said nothing, instead of getting ready."""


class OwnServer:
    """One ``python -m simx_server SCENE`` on free ports, to which the script's hard-wired ones are redirected.

    The simulation is not started: a script that comes by port 19999 finds it running, as in V-REP, and one that
    comes by 19997 starts it itself, perhaps after setting a time step or stepped mode.
    """

    def __init__(self, scene: str, arguments: Sequence[str] = ()) -> None:
        free = [] if "--port" in arguments else ["--port", "0"] * len(USUAL_PORTS)
        # -P: the working folder is its workspace, where clients may put modules.
        self._command = [sys.executable, "-P", "-m", "simx_server", scene, *free, *arguments]
        self._has_config = any(re.match(r"-c|--config\b", argument) for argument in arguments)
        self._redirects: dict[int, tuple[str, int]] = {}
        self._process: subprocess.Popen[str] | None = None
        self._is_ready = False
        self._ready_or_ended = threading.Event()

    def start(self, timeout_s: float) -> None:
        """Returns when the server has said that it is ready; raises ServerNotReady otherwise."""
        self._process = subprocess.Popen(
            self._command,
            # What the variable names is the client's configuration, with its login and keys.
            env={name: value for name, value in os.environ.items() if name != CONFIG_VARIABLE},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            text=True,
            # a group of its own: Ctrl-C is for the script, which may still want its server
            start_new_session=os.name == "posix",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # the same on Windows
        )
        assert self._process.stdout is not None
        threading.Thread(target=self._read, args=(self._process.stdout,), daemon=True).start()
        has_answered = self._ready_or_ended.wait(timeout_s)
        if self._is_ready:
            if self._redirects and VARIABLE not in os.environ:
                os.environ[VARIABLE] = format_redirects(self._redirects)
            if not self._has_config and os.environ.pop(CONFIG_VARIABLE, ""):
                logger.info("%s is left out: the script's own server asks for no login", CONFIG_VARIABLE)
            return
        if has_answered:
            code, self._process = self._process.wait(), None
            raise ServerNotReady(f"simx-server ended with code {code} before it was ready; see above for why")
        self.stop()
        raise ServerNotReady(
            f"simx-server was not ready within {timeout_s:g} s; see what it says by itself "
            f"(python {' '.join(self._command[1:])}) or give it longer with --server-timeout"
        )

    def stop(self) -> None:
        """End the server and wait for it; a server that is gone already is said so in the log."""
        if self._process is None:
            return
        if (code := self._process.poll()) is not None:
            logger.warning("simx-server had ended by itself with code %d", code)
        else:
            self._process.terminate()
            try:
                self._process.wait(STOP_WITHIN_S)
            except subprocess.TimeoutExpired:
                logger.warning("simx-server did not end within %g s and was killed", STOP_WITHIN_S)
                self._process.kill()
                self._process.wait()
        self._process = None

    def _read(self, stdout: IO[str]) -> None:
        """Wait for the ready line, then keep the pipe empty so that the server can never block on it."""
        with stdout:
            for line in stdout:
                logger.debug("simx-server: %s", line.rstrip())
                if re.match(r"ready\b", line) and not self._is_ready:
                    ports = map(int, re.findall(r"tcp/127\.0\.0\.1:(\d+)", line))
                    self._redirects = {
                        usual: ("127.0.0.1", port) for usual, port in zip(USUAL_PORTS, ports, strict=False)
                    }
                    self._is_ready = True
                    self._ready_or_ended.set()
        self._ready_or_ended.set()
