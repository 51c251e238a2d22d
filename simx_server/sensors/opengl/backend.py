"""Choose the OpenGL back end: the user's choice, else the first that works, else ray casting.

The test is a small image rendered and checked in a child process (`gl_probe`), because a broken graphics driver may
kill or hang the process that tries it. That takes about half a second, so choose on the thread that renders; a
server forks a child for the first back end while it starts (`gl_early`), which takes a quarter of it.

mujoco's own choice at import is not used: each back end's context class is taken from its module. Those modules set
PYOPENGL_PLATFORM only where it is unset, and read MUJOCO_EGL_DEVICE_ID; both stay the user's.
"""

import contextlib
import importlib
import logging
import os
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import RenderError
from simx_server.processes.delays import delay

from .libraries import INSTALL_HINT, why_it_fails

logger = logging.getLogger(__name__)

RAYCAST = "raycast"
_CONTEXT_MODULES = {
    "egl": "mujoco.egl",
    "osmesa": "mujoco.osmesa",
    "glfw": "mujoco.glfw",
    "cgl": "mujoco.cgl",  # macOS, where GLFW works on the main thread only
}
_ASKED_FOR = {name: name for name in _CONTEXT_MODULES} | {
    "glx": "glfw",
    "wgl": "glfw",
    **dict.fromkeys(("disable", "disabled", "off", "false", "0", RAYCAST), RAYCAST),
    **dict.fromkeys(("", "enable", "enabled", "on", "true", "1"), None),
}
PROBE_LIMIT = 20.0
"""Time-out in seconds for one back end, without the time in which its process waits for a processor."""

DIES_WITHIN = 1.0
"""Seconds to wait for a killed probe.

A probe that hangs in the kernel's part of a driver never dies; it is abandoned.
"""

_TOLD = 240
"""Maximum number of characters of a probe's message."""

_PACKAGE_ROOT = Path(__file__).resolve().parents[3]


Probe = Callable[[str, threading.Event], str | None]
"""Tries a back end by name until an event is set; returns None if it works, else the problem."""


@dataclass(frozen=True)
class Backend:
    """The chosen back end and, in one sentence for the log, the reason."""

    name: str
    """egl, osmesa, glfw, cgl (macOS) or raycast."""
    reason: str


def requested_backend(requested: str | None = None) -> str | None:
    """Return the back end requested by argument or MUJOCO_GL, None if the choice is free.

    Cheap, so a server can call it at start to refuse a wrong value early.

    Raises:
        ValueError: not a value of MUJOCO_GL.
    """
    asked = (os.environ.get("MUJOCO_GL", "") if requested is None else requested).lower().strip()
    if asked not in _ASKED_FOR:
        valid = ", ".join(sorted(name for name in _ASKED_FOR if name))
        raise ValueError(
            f"MUJOCO_GL={asked!r} is not a way to render; valid are {valid}; "
            "leave it unset to take the first that works"
        )
    return _ASKED_FOR[asked]


def candidates() -> Sequence[str]:
    """Return the back ends to probe on this platform, best first."""
    if sys.platform == "linux":
        return ("egl", "osmesa", "glfw")
    return ("cgl", "glfw") if sys.platform == "darwin" else ("glfw",)


def choose_backend(
    requested: str | None = None,
    *,
    probe: Probe | None = None,
    give_up: threading.Event | None = None,
) -> Backend:
    """Return the back end to render with.

    Args:
        requested: a value of MUJOCO_GL; None reads that variable. A requested back end is used without a probe.
        probe: tries one back end: None if it works, else the problem; by default `probe_once`.
        give_up: set it to end probing early, for a server that closes.

    Raises:
        ValueError: `requested` or MUJOCO_GL is not a known value.
        RenderError: `give_up` was set.
    """
    asked = requested_backend(requested)
    if asked is not None:
        source = " in MUJOCO_GL" if requested is None else ""
        return Backend(asked, f"{asked} was asked for{source}")
    probe = probe or probe_once
    give_up = give_up or threading.Event()
    failures: list[str] = []
    for name in candidates():
        wrong = probe(name, give_up)
        if give_up.is_set():
            raise RenderError("the choice of a back end was given up because rendering is closing")
        if wrong is None:
            return Backend(name, f"{name} rendered a test image")
        logger.debug("%s cannot render: %s", name, wrong)
        failures.append(f"{name}: {wrong}")
    return Backend(RAYCAST, f"no OpenGL back end works ({'; '.join(failures)}); {INSTALL_HINT}")


_SET_BY_MUJOCO = "PYOPENGL_PLATFORM"
_probing = threading.Lock()
_working: set[tuple[str, frozenset[tuple[str, str]]]] = set()
"""Back ends that have rendered the test image, each with the environment variables of that time."""


def probe_once(name: str, give_up: threading.Event) -> str | None:
    """Do as `probe_in_child`; a back end that works is tried once for all simulations of this process."""
    while not _probing.acquire(timeout=0.1):
        if give_up.is_set():
            return "given up"
    try:
        tried = name, frozenset(each for each in os.environ.items() if each[0] != _SET_BY_MUJOCO)
        wrong = None if tried in _working else probe_in_child(name, give_up)
        if wrong is None:
            _working.add(tried)
        return wrong
    finally:
        _probing.release()


def probe_in_child(name: str, give_up: threading.Event) -> str | None:
    """Render a test image in a child process with one back end; return None if it is correct, else the problem."""
    environment = os.environ.copy()
    # "on" and similar values only enable rendering; the child must not fail on them at import.
    environment.pop("MUJOCO_GL", None)
    environment["PYTHONPATH"] = os.pathsep.join(
        filter(None, (str(_PACKAGE_ROOT), environment.get("PYTHONPATH")))
    )
    child = subprocess.Popen(
        [sys.executable, "-P", "-m", "simx_server.sensors.opengl.probe", name],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
    )
    deadline = time.monotonic() + PROBE_LIMIT
    while True:
        try:
            _, complaint = child.communicate(timeout=0.1)
            break
        except subprocess.TimeoutExpired:
            if time.monotonic() > deadline + delay(child.pid) or give_up.is_set():
                child.kill()
                with contextlib.suppress(subprocess.TimeoutExpired):
                    child.communicate(timeout=DIES_WITHIN)
                return "given up" if give_up.is_set() else f"no answer within {PROBE_LIMIT:.0f} s"
    return outcome(child.returncode, complaint)


def outcome(exit_code: int, complaint: str) -> str | None:
    """Return the result of a probe from its exit status and the last line that it wrote: None, or the problem."""
    if exit_code == 0:
        return None
    if exit_code < 0:
        return f"the driver ended its process with signal {-exit_code}"
    lines = complaint.strip().splitlines()
    return textwrap.shorten(lines[-1], _TOLD) if lines else f"exit status {exit_code}"


def make_gl_context(name: str, width: int, height: int) -> Any:
    """Make mujoco's OpenGL context of one back end: `make_current()` and `free()`, on the thread that made it.

    Raises:
        RenderError: its library or its driver is missing or broken.
    """
    try:
        return importlib.import_module(_CONTEXT_MODULES[name]).GLContext(width, height)
    # A missing library raises ImportError, OSError, AttributeError or GLError, by back end and its version.
    except Exception as error:
        raise RenderError(
            f"no OpenGL context with {name} ({why_it_fails(name, error)}); unset MUJOCO_GL to take the "
            f"first back end that works, or set MUJOCO_GL=disable to cast rays; {INSTALL_HINT}"
        ) from error
