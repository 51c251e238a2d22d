"""A private simx-server for the script: started and ready before the script, stopped after it.

The server exits with this process, however it ends: its standard input is a pipe from here, and `simx-server
--until-eof` exits when that pipe closes.
"""

from __future__ import annotations

import json
import logging
import os
import re
import subprocess
import sys
import threading
from collections.abc import Sequence
from typing import IO

from simx_client.errors import SimxError
from simx_client.protocol.cli.installing import missing_server
from simx_client.transport.redirect import ANY_PORT, VARIABLE, Redirects, format_redirects, read_redirects
from simx_client.transport.zenoh_session import CONFIG_VARIABLE

logger = logging.getLogger(__name__)

FIRST_PORT = 19997
"""First of the ports at which old scripts expect several simulators; the others follow."""

STOP_WITHIN_S = 5.0  # the server exits within two seconds after SIGTERM


class ServerNotReady(SimxError):
    """The server exited, or printed nothing, instead of getting ready."""


class OwnServer:
    """A ``python -m simx_server SCENE`` on a free port, to which all connections of the script are
    redirected.

    The simulation is not started: for a script that connects to port 19999 it runs, as in V-REP, and a script
    that connects to 19997 starts it, perhaps after setting a time step or stepped mode.
    """

    def __init__(
        self, scene: str, arguments: Sequence[str] = (), *, with_zmq: bool = False, with_model: bool = False
    ) -> None:
        """Prepare a server; ``start`` starts it.

        Args:
            arguments: more for its command line.
            with_zmq: it also serves clients of the ZeroMQ remote API, at `zmq_port`.
            with_model: it also serves clients of API 2, at `model_port`.
        """
        self.zmq_port: int | None = None
        self.model_port: int | None = None
        has_port = any(re.match(r"-p|--port\b", argument) for argument in arguments)
        # Its ports, and those that the scene's scripts would open, belong to other servers.
        free = [] if has_port else ["--port", "0", "--no-script-ports"]
        if with_zmq and not any(re.match(r"--zmq(=|$)", argument) for argument in arguments):
            free += ["--zmq", "0"]
        if with_model and not any(argument.startswith("--zmq2") for argument in arguments):
            free += ["--zmq2", "0"]
        # -P: the working folder is the server's workspace, in which clients may put modules.
        self._command = [sys.executable, "-P", "-m", "simx_server", scene, *free, *arguments, "--until-eof"]
        self._has_config = any(re.match(r"-c|--config\b", argument) for argument in arguments)
        self._redirects: Redirects = {}
        self._process: subprocess.Popen[str] | None = None
        self._is_ready = False
        self._ready_or_ended = threading.Event()

    def start(self, timeout_s: float) -> None:
        """Return when the server has printed that it is ready; raise ServerNotReady otherwise."""
        if missing := missing_server():
            raise ServerNotReady(missing)
        of_user = _rules_of_user()
        self._process = subprocess.Popen(
            self._command,
            # The variable names the client's configuration, with its login and keys.
            env={name: value for name, value in os.environ.items() if name != CONFIG_VARIABLE},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            # a separate group: Ctrl-C is for the script, which may still use its server
            start_new_session=os.name == "posix",
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),  # the same on Windows
        )
        if hasattr(os, "register_at_fork"):  # Windows cannot fork
            os.register_at_fork(after_in_child=self._let_go)
        assert self._process.stdout is not None
        threading.Thread(target=self._read, args=(self._process.stdout,), daemon=True).start()
        has_answered = self._ready_or_ended.wait(timeout_s)
        if self._is_ready:
            os.environ[VARIABLE] = format_redirects({**self._redirects, **of_user})
            if not self._has_config and os.environ.pop(CONFIG_VARIABLE, ""):
                logger.info("%s is left out: the script's own server asks for no login", CONFIG_VARIABLE)
            return
        if has_answered:
            code = self._process.wait()
            self._let_go()
            raise ServerNotReady(f"simx-server ended with code {code} before it was ready; see above for why")
        self.stop()
        raise ServerNotReady(
            f"simx-server was not ready within {timeout_s:g} s; see what it prints on its own "
            f"(python {' '.join(self._command[1:-1])}) or give it longer with --server-timeout"
        )

    @staticmethod
    def _ask_to_end(process: subprocess.Popen[str]) -> None:
        if sys.platform == "win32":  # `terminate` would end it at once, in the middle of a recording
            assert process.stdin is not None
            process.stdin.close()  # --until-eof
        else:
            process.terminate()

    def stop(self) -> None:
        """Stop the server and wait for it; log if it has exited before."""
        if self._process is None:
            return
        if (code := self._process.poll()) is not None:
            logger.warning("simx-server had already exited with code %d", code)
        else:
            self._ask_to_end(self._process)
            try:
                self._process.wait(STOP_WITHIN_S)
            except subprocess.TimeoutExpired:
                logger.warning("simx-server did not end within %g s and was killed", STOP_WITHIN_S)
                self._process.kill()
                self._process.wait()
        self._let_go()

    def _let_go(self) -> None:
        """Close the pipe by which the server notices the end of this process, and forget the server.

        A forked child of the script does the same: its copy of the pipe would keep the server alive.
        """
        if self._process is not None:
            assert self._process.stdin is not None
            self._process.stdin.close()
            self._process = None

    def _read(self, stdout: IO[str]) -> None:
        """Wait for the ready line, then keep the pipe empty so that it never blocks the server."""
        with stdout:
            for line in stdout:
                logger.debug("simx-server: %s", line.rstrip())
                if not self._is_ready and (redirects := _redirects(line)) is not None:
                    self._redirects = redirects
                    self.zmq_port = next(map(int, re.findall(r"zmq/[^\s:]+:(\d+)", line)), None)
                    self.model_port = next(map(int, re.findall(r"zmq2/[^\s:]+:(\d+)", line)), None)
                    self._is_ready = True
                    self._ready_or_ended.set()
        self._ready_or_ended.set()


def _redirects(line: str) -> Redirects | None:
    """Return the endpoints of the script's ports from the server's ready line; None for another line.

    A single server gets all ports. Of a fleet (``--count``) the first server gets 19997, the second 19998,
    and so on; ports chosen with ``--port`` need no redirection.
    """
    if line.startswith('{"servers": '):
        places = json.loads(line)["servers"]
        return {
            FIRST_PORT + number: ("127.0.0.1", place["ports"][0])
            for number, place in enumerate(places)
            if place["ports"]
        }
    if not re.match(r"ready\b", line):
        return None
    ports = re.findall(r"tcp/127\.0\.0\.1:(\d+)", line)
    return {ANY_PORT: ("127.0.0.1", int(ports[0]))} if ports else {}


def _rules_of_user() -> Redirects:
    """Return the user's redirections of single ports; one of all ports would leave the server unused.

    Raises:
        ServerNotReady: the variable cannot be read.
    """
    try:
        return {asked: place for asked, place in read_redirects().items() if asked != ANY_PORT}
    except ValueError as error:
        raise ServerNotReady(str(error)) from None
