"""Try the first back end in a forked child while the rest of the server is still being imported. Linux only.

A fork has mujoco imported already, so it costs a quarter of a probe in a new process, and mostly it is done before
the scene is loaded. On one core it would delay the start by as long as it takes, so there it waits for the server to
load the scene. Fork before any other thread starts: a lock held by a thread at that instant would stay locked
in the child forever.
"""

import contextlib
import os
import re
import select
import signal
import sys
import threading
import time
from pathlib import Path
from typing import NoReturn

from simx_client.protocol.files import is_vrep_name
from simx_server.errors import CommandError
from simx_server.files.library import find_scene
from simx_server.processes.delays import delay

from .backend import (
    DIES_WITHIN,
    PROBE_LIMIT,
    candidates,
    outcome,
    probe_in_child,
    requested_backend,
)
from .probe import what_is_wrong

_INCLUDE = re.compile(rb"""<include[^>]*\sfile\s*=\s*["']([^"']+)""")
_CAMERA = re.compile(rb"""<camera\b[^>]*\sname\s*=\s*["']([^"']+)""")
"""The name of a camera; a camera without a name is mostly a default."""

_VIEW = re.compile(rb"""["']simx:camera:([^"']+)["']""")
"""A name that an annotation makes V-REP's camera of a view, which is not a vision sensor."""

_DEEPEST = 4
_GLANCE = 0.1
"""Seconds between two checks of the cancellation event."""


def begin_early(scene: str) -> "EarlyProbe | None":
    """Try the first back end in a child, if images of this scene are likely and the choice is free.

    Args:
        scene: as `find_scene` takes it.

    Raises:
        ValueError: MUJOCO_GL has a wrong value.
    """
    if sys.platform != "linux" or requested_backend() is not None:
        return None
    try:
        is_wanted = may_have_cameras(find_scene(scene))
    except CommandError:  # loading the scene reports the error
        return None
    is_alone = len(os.listdir("/proc/self/task")) == 1
    return EarlyProbe() if is_wanted and is_alone else None


def may_have_cameras(scene: Path, depth: int = 0) -> bool:
    """Return whether a scene file seems to have cameras, from its text and the files that it includes.

    A V-REP file has no text that could be searched before it is decoded; many of them have vision sensors. A wrong
    guess costs only time.
    """
    if is_vrep_name(scene.name):
        return True
    try:
        text = scene.read_bytes()
    except OSError:
        return False  # loading the scene reports the error
    if set(_CAMERA.findall(text)) - set(_VIEW.findall(text)):
        return True
    included = (scene.parent / os.fsdecode(name) for name in _INCLUDE.findall(text))
    return depth < _DEEPEST and any(may_have_cameras(each, depth + 1) for each in included)


_LONGEST = 120
"""Seconds until the child ends on its own: `PROBE_LIMIT`, and the wait for processors of a busy machine."""


class EarlyProbe:
    """The running probe of the first back end. It is callable as a `Probe`; other back ends are tried as usual."""

    def __init__(self) -> None:
        self._name = candidates()[0]
        self._reader, writer = os.pipe()
        may_begin, self._begins = os.pipe()
        self._child: int | None = os.fork()
        if self._child == 0:
            os.close(self._begins)
            _become_probe(self._name, writer, may_begin)
        os.close(writer)
        os.close(may_begin)
        if len(os.sched_getaffinity(0)) > 1:
            self._begin()

    def __call__(self, name: str, give_up: threading.Event) -> str | None:
        """Try a back end as `gl_backend.probe_in_child` does: return None if it works, else the problem."""
        if name != self._name or self._child is None:
            return probe_in_child(name, give_up)
        self._begin()
        said, limit = b"", time.monotonic() + PROBE_LIMIT
        while time.monotonic() < limit + delay(self._child) and not give_up.is_set():
            if select.select([self._reader], [], [], _GLANCE)[0]:
                part = os.read(self._reader, 4096)
                if not part:
                    return outcome(self._reap(), said.decode(errors="replace"))
                said += part
        self.close()
        return "given up" if give_up.is_set() else f"no answer within {PROBE_LIMIT:.0f} s"

    def close(self) -> None:
        """End it, if it is still running. Not while another thread calls it."""
        if self._child is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._child, signal.SIGKILL)
            self._reap()

    def _begin(self) -> None:
        """Have the child try the back end. Idempotent."""
        with contextlib.suppress(BrokenPipeError):  # it has started, and may have ended
            os.write(self._begins, b"\n")

    def _reap(self) -> int:
        """Return how the child ended. In a driver's kernel part it may hang forever, killed or not."""
        assert self._child is not None
        child, self._child = self._child, None
        os.close(self._reader)
        os.close(self._begins)
        limit = time.monotonic() + DIES_WITHIN
        while (ended := os.waitpid(child, os.WNOHANG))[0] == 0:
            if time.monotonic() > limit:
                return 1
            time.sleep(0.001)
        return os.waitstatus_to_exitcode(ended[1])


def _become_probe(name: str, writer: int, may_begin: int) -> NoReturn:
    """Run the child: it must never return into the parent's code."""
    exit_code = 1
    try:
        if (wakeup := signal.set_wakeup_fd(-1)) >= 0:  # the server's; see its watchdog
            os.close(wakeup)
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        for standard in (1, 2):  # the ready line's pipe must not stay open here; a driver may write anything
            os.dup2(writer, standard)
        if not os.read(may_begin, 1):  # the server is gone
            os._exit(1)
        signal.alarm(_LONGEST)  # ends it, even if the server is gone
        wrong = what_is_wrong(name)
        exit_code = 0 if wrong is None else 1
        os.write(writer, f"\n{wrong or ''}\n".encode())
    finally:
        os._exit(exit_code)
