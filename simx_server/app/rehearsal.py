"""Start the scripts of a scene in a child process, for the import report: which of them an error stops.

A script may loop for ever or fill the memory, so the child has limits, as the trial of a client's file has. Its images
are black and its depth maps empty, since drawing takes long. It writes files in a temporary folder only. Each finding
reaches the parent at once: a child that is killed has reported the stops before.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from simx_server.errors import CommandError, shortened
from simx_server.limits import Limits
from simx_server.scene.cameras.image import CameraImage, CameraView, nothing
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.vrep.report import Rehearsal
from simx_server.sensors.opengl.backend import Backend
from simx_server.simulation.part import Part

SECONDS = 2.0
"""Simulated time of the run."""

PROCESSOR = 20
"""Seconds of processor time that the child may take."""

WAIT = 30
"""Seconds that the child may take."""

_ENOUGH = 10.0
"""Seconds of processor time after which the child makes no further simulation step."""

_MOST = 1 << 20
"""Most bytes of the child's report."""

_MOST_STOPS = 1000

_START = "import sys; sys.path[:] = sys.argv[1:]; from simx_server.app.rehearsal import main; main()"


def rehearse(file: Path, sources: Sources, limits: Limits) -> Rehearsal:
    """Run the scripts of a scene or model for a moment, in a child process with limits.

    Args:
        file: the V-REP file.
        sources: folders to search for the files that it names.
        limits: `load_memory` is the memory of the child.
    """
    with tempfile.TemporaryDirectory(prefix="simx-rehearsal-", ignore_cleanup_errors=True) as folder:
        request = {
            "file": str(file.resolve()),
            "sources": sources.described(),
            "workspace": folder,
            "limits": dataclasses.asdict(dataclasses.replace(limits, load_seconds=PROCESSOR, load_wait=WAIT)),
        }
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "MUJOCO_GL": "disable"}
        child = subprocess.Popen(
            [sys.executable, "-P", "-B", "-c", _START, *filter(os.path.isabs, sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=environment,
            start_new_session=True,
        )
        clock = threading.Timer(WAIT, child.kill)
        clock.start()
        try:
            said = _exchange(child, json.dumps(request).encode())
        finally:
            clock.cancel()
            child.kill()
            child.wait()
    return _understood(said, child.returncode)


def _exchange(child: subprocess.Popen[bytes], request: bytes) -> bytes:
    """Send a request; return what the child reports until its end."""
    assert child.stdin is not None
    assert child.stdout is not None
    with child.stdin, child.stdout:
        child.stdin.write(request)
        child.stdin.close()
        said = child.stdout.read(_MOST)
        child.wait(WAIT)
    return said


def _understood(said: bytes, exit_code: int) -> Rehearsal:
    """Return the child's report; its last line may be cut."""
    rehearsal, is_complete = Rehearsal(), False
    for line in said.splitlines():
        try:
            record: dict[str, Any] = json.loads(line)
        except ValueError:
            continue
        rehearsal.seconds = record.get("seconds", rehearsal.seconds)
        rehearsal.stops += record.get("stops", [])
        rehearsal.ended_by = record.get("ended_by", rehearsal.ended_by)
        is_complete = is_complete or "ended_by" in record
    if not is_complete:
        rehearsal.ended_by = _reason(exit_code)
    return rehearsal


def _reason(exit_code: int) -> str:
    """Return why a child has ended without the end of its report."""
    if exit_code >= 0:
        return f"the process ended with code {exit_code}"
    name = signal.Signals(-exit_code).name
    if name in ("SIGXCPU", "SIGPROF"):
        return f"it took {PROCESSOR} s of processor time"
    if name in ("SIGALRM", "SIGKILL"):
        return f"it took {WAIT} s, or too much memory"
    return f"the process ended with {name}"


# --- the child ------------------------------------------------------------------------------------


class _Blank:
    """Renders images in which nothing is seen."""

    def turn_to(self, model: mujoco.MjModel) -> None: ...

    def render(
        self,
        data: mujoco.MjData,
        view: CameraView,
        rgb: bool,
        depth: bool,
        let_in: Callable[[], None] = nothing,
    ) -> CameraImage:
        shape = view.height, view.width
        return CameraImage(np.zeros((*shape, 3), np.uint8), np.ones(shape, np.float32))

    def render_both(
        self,
        data: mujoco.MjData,
        view: CameraView,
        coded: CameraView,
        let_in: Callable[[], None] = nothing,
    ) -> tuple[CameraImage, CameraImage]:
        return (
            self.render(data, view, rgb=True, depth=True),
            self.render(data, coded, rgb=True, depth=True),
        )

    def rest(self) -> None: ...

    def close(self) -> None: ...


class _Collector(Part):
    """Reports each script that is stopped."""

    def __init__(self, writer: int) -> None:
        self._writer = writer
        self._stops = 0

    def script_stopped(self, problem: str) -> None:
        self._stops += 1
        if self._stops <= _MOST_STOPS:
            self.report(stops=[shortened(problem)])

    def report(self, **record: Any) -> None:
        """Send a line to the parent."""
        os.write(self._writer, json.dumps(record).encode() + b"\n")


def main() -> None:
    """Read a request from standard input, run the scripts, report at what was standard output."""
    request = json.load(sys.stdin)
    writer = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # scripts may print
    logging.disable(logging.CRITICAL)
    collector = _Collector(writer)
    try:
        ended_by = _run(request, collector)
    except MemoryError:
        ended_by = "it took too much memory"
    except CommandError as error:
        ended_by = str(error)
    collector.report(ended_by=ended_by)
    os._exit(0)


def _run(request: dict[str, Any], collector: _Collector) -> str:
    """Load the scene and make the steps; return why it was ended early, or nothing."""
    # Slow, and needed by the child only.
    from simx_server.scene.trial.child import limit_process
    from simx_server.sensors.rendering.render_thread import RenderThread
    from simx_server.simulation.simulation import SimulationState

    from .building import build_world

    limits, file = Limits(**request["limits"]), Path(request["file"])
    limit_process(limits, 0, file_size=limits.file)
    rendering = RenderThread(
        choose=lambda: Backend("blank", "no images are drawn"),
        make=lambda _model, _backend: _Blank(),
        limits=limits,
    )
    world = build_world(
        rendering,
        workspace=Path(request["workspace"]),
        limits=limits,
        sources=Sources.described_as(request["sources"], Path),
        own_scene=file,
    )
    simulation = world.simulation
    simulation.parts.attach(collector)
    simulation.load(file)
    simulation.start()
    while simulation.state is not SimulationState.STOPPED:
        collector.report(seconds=round(simulation.time, 6))
        if simulation.time >= SECONDS:
            break
        if time.process_time() > _ENOUGH:
            return f"it took {_ENOUGH:g} s of processor time"
        world.step()
    return ""
