"""The trial of one file, in a separate process with limits: it does the same work as the server later.

The limits apply before the first byte of the file is parsed. When its files are read the process loses the ability to
open any, so a file that MuJoCo would open beyond them is refused instead of being loaded untried.
"""

from __future__ import annotations

import codecs
import copy
import ctypes
import gc
import logging
import math
import signal
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco

from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.parts.user_interface.custom_ui_files import read_ui_file
from simx_server.scene.finding.references import check_references
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.contents import digests
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.formats.loose_meshes import settle_loose_meshes
from simx_server.scene.formats.meshes.reading import prepare as prepare_libraries
from simx_server.scene.formats.model_files import read_model
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf.recognising import count_links
from simx_server.scene.formats.vrep.recognising import is_vrep
from simx_server.scene.geometry.overlaps import log_overlaps

from .gathering import gather
from .kinds import MESH, MODEL, SCENE, UI

try:
    import resource
except ImportError:  # Windows, where only the server's clock limits a trial
    resource = None  # type: ignore[assignment]

_SPARE = 32 << 20
"""Bytes beyond the limit of memory for building the result."""

for _name in ("ascii", "latin-1", "utf-8", "utf-16", "utf-32", "idna", "cp1252", "cp437"):
    codecs.lookup(_name)  # these are files, which the child cannot open any more when it needs them

_M_ARENA_MAX = -8
_PR_SET_PDEATHSIG = 1

_EXHAUSTED = ("llocat", "bad_alloc")
"""Parts of MuJoCo's error texts when memory is exhausted."""

_ERRORS = {"SceneError": SceneError, "CommandError": CommandError}


def try_file(request: Mapping[str, Any]) -> dict[str, Any]:
    """Set the limits of this process and execute a request; the process must not be used afterwards.

    Returns:
        ``files`` (path to the value of `digests`) after success; ``limit``, the name of a passed limit; or ``error``,
        the class of an error, and ``text``.
    """
    logging.disable(logging.CRITICAL)
    gc.disable()
    limits = Limits(**request["limits"])
    top = limit_process(limits, int(request["held"]))
    try:
        return {"files": _try(request, limits)}
    except MemoryError:
        problem: Exception | None = None
    except RecursionError:
        problem = CommandError(f"'{request['name']}' is nested too deeply")
    except (CommandError, ValueError, RuntimeError, mujoco.FatalError) as error:
        problem = error
    except Exception as error:  # a fault of this program, which the client's file must not hide
        text = f"'{request['name']}' cannot be loaded: internal error, {type(error).__name__}: {error}"
        problem = SceneError(text)
    # The limit itself must not prevent the report that it was passed.
    if resource is not None and top is not None:
        resource.setrlimit(resource.RLIMIT_AS, top)
    if problem is None or (top is not None and _is_exhausted(problem)):
        return {"limit": "load_memory"}
    kind = next((kind for kind in ("SceneError", "CommandError") if isinstance(problem, _ERRORS[kind])), "")
    return {"error": kind or "SceneError", "text": str(problem)}


def limit_process(limits: Limits, held: int, *, file_size: int = 0) -> tuple[int, int] | None:
    """Set all limits of this process, which also ends with its parent.

    Args:
        limits: those of loading are used.
        held: bytes of memory to subtract.
        file_size: most bytes of a file that it writes.

    Returns:
        The memory limits to use at the end; None where there is none.
    """
    if resource is None:
        return None
    if sys.platform == "linux":  # the parent kills it, unless the parent itself is killed
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    seconds = math.ceil(limits.load_seconds)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    for number in (signal.SIGPROF, signal.SIGALRM):
        signal.signal(number, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, limits.load_seconds)  # it counts parts of seconds, unlike RLIMIT_CPU
    signal.setitimer(signal.ITIMER_REAL, limits.load_wait)
    if sys.platform != "linux":
        return None  # the system accepts the limit and does not enforce it
    # Separate arenas of the C library for each thread would take unused address space.
    ctypes.CDLL(None).mallopt(_M_ARENA_MAX, 1)
    now = _address_space(resource.getpagesize())
    most = now + max(0, limits.load_memory - held)
    resource.setrlimit(resource.RLIMIT_AS, (most, most + _SPARE))
    return most + _SPARE, most + _SPARE


def _address_space(page: int) -> int:
    with open("/proc/self/statm", "rb") as pages:
        return int(pages.read().split()[0]) * page


def _is_exhausted(problem: Exception) -> bool:
    """Return whether an error means that memory was exhausted."""
    return any(word in str(problem) for word in _EXHAUSTED)


def _try(request: Mapping[str, Any], limits: Limits) -> dict[str, str]:
    path, name = Path(request["path"]), str(request["name"])
    if request["kind"] == UI:
        contents = gather(path, Sources.of())
        read_ui_file(path, contents.read(path))
        return digests(contents)
    sources = Sources.described_as(request["sources"], Path)
    if request["within"] is not None:
        sources = replace(sources, within=tuple(map(Path, request["within"])))
    sources = sources.for_one_read()
    contents = gather(path, sources)
    sources = sources.holding(contents)
    if sources.within is not None:
        check_references(path, sources.within, contents)
    data = contents.read(path)
    links = count_links(data)
    limits.check("objects", links, f"'{name}' has {links} links")
    if is_vrep(data, path.name):
        from simx_server.scene.formats.vrep.opening import prepare_for_trial  # slow, and often not needed

        prepare_for_trial()
    prepare_libraries(contents.assets)
    _open_no_more_files()
    _WORK[request["kind"]](path, name, sources, limits)
    return digests(contents)


def _open_no_more_files() -> None:
    if resource is not None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0))


def _load_scene(path: Path, name: str, sources: Sources, limits: Limits) -> None:
    scene, model = load_scene(path, sources, name)
    limits.check("objects", len(scene.objects), f"'{scene.name}' has {len(scene.objects)}")
    log_overlaps(scene, model, _run(model, limits))


def _load_model(path: Path, name: str, sources: Sources, limits: Limits) -> None:
    model = read_model(path, name, sources)
    limits.check("objects", len(model.scene.objects), "remove some")
    spec = model.scene.spec.copy()
    if model.scene.import_report is None:
        settle_loose_meshes(spec)
    scene = mujoco.MjSpec()
    scene.attach(spec, prefix="m/", frame=scene.worldbody.add_frame())
    _run(scene.compile(), limits)


def _read_mesh(path: Path, name: str, sources: Sources, limits: Limits) -> None:
    read_model(path, name, sources)


_WORK: Mapping[str, Callable[[Path, str, Sources, Limits], None]] = {
    SCENE: _load_scene,
    MODEL: _load_model,
    MESH: _read_mesh,
}


def _run(model: mujoco.MjModel, limits: Limits) -> mujoco.MjData:
    """Execute the first physics step, with all its allocations; return the state before it.

    The server does this on the thread that answers its clients, so a second of processor time must be enough.
    """
    if resource is not None:
        used = math.ceil(time.process_time())
        seconds = math.ceil(limits.load_seconds)
        resource.setrlimit(resource.RLIMIT_CPU, (min(seconds, used + 1), seconds + 1))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    before = copy.copy(data)
    mujoco.mj_step(model, data)
    return before
