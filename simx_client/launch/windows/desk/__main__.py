"""Own the windows of one script: read messages from stdin, write reports to stdout, exit at the end of stdin."""

from __future__ import annotations

import os
import sys
import threading

from ..display import FAILED, READY
from ..outbox import Outbox
from ..pipe import read_all, write
from .backend import Backend, NoBackend

PAUSE = 0.01
"""Seconds between two polls of the window system's events while no message comes."""

ONLY = "SIMX_WINDOWS"
"""Variable that selects one window system, tk or pygame."""


def main() -> int:
    """Run the process; return the exit code."""
    source, target = os.dup(0), os.dup(1)
    os.dup2(2, 1)  # output of libraries is not a report
    try:
        backend = _backend()
    except NoBackend as reason:
        write(target, (FAILED, str(reason)))
        return 1
    write(target, (READY, backend.name))
    inbox = Outbox()
    threading.Thread(target=_read, args=(source, inbox), daemon=True).start()
    try:
        _serve(backend, inbox, target)
    except BrokenPipeError:  # the script has ended
        return 0
    return 0


def _serve(backend: Backend, inbox: Outbox, target: int) -> None:
    from .windows import Desk

    desk = Desk(backend, lambda report: write(target, report))
    while True:
        for message in inbox.take(PAUSE):
            desk.do(message)
        desk.tick()
        backend.pump()


def _read(source: int, inbox: Outbox) -> None:
    for message in read_all(source):
        inbox.put(message)
    os._exit(0)


def _backend() -> Backend:
    """Return the first window system that works. Raises NoBackend, with what to install."""
    from . import sdl, tk

    chosen = os.environ.get(ONLY, "").strip()
    known = {"tk": tk.open_tk, "pygame": sdl.open_sdl}
    if chosen and chosen not in known:
        raise NoBackend(f"{ONLY}: there is no window system {chosen!r}; valid: {', '.join(known)}")
    reasons: list[str] = []
    for name, open_backend in known.items():
        if chosen in ("", name):
            try:
                return open_backend()
            except NoBackend as reason:
                reasons.append(str(reason))
    raise NoBackend("; ".join(reasons))


if __name__ == "__main__":
    sys.exit(main())
