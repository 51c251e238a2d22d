"""Report the counters of a server to operators, as health and metrics. Physics thread."""

from __future__ import annotations

import mmap
import os
import socket
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from operator import sub
from pathlib import Path

from simx_client.protocol.messages import PROTOCOL_VERSION
from simx_client.protocol.reports import (
    Calls,
    Client,
    Command,
    DepartedClient,
    Health,
    Images,
    Metrics,
    Percentiles,
    Process,
    Steps,
    Timing,
)
from simx_server import __version__
from simx_server.durations import Histogram, percentiles
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.service.clients.sessions import ClientSession, Departed
from simx_server.service.service import Service

from .metrics import Failures, Sample


def health(service: Service, realm: str) -> Health:
    """Return the health report for a supervisor. Any thread, as long as the physics thread is busy."""
    return {
        "protocol": PROTOCOL_VERSION,
        "realm": realm,
        "server": __version__,
        "state": service.simulation.state.value,
        "age": service.metrics.age,
        "problems": _problems(service),
    }


def metrics(service: Service, realm: str, ports: Sequence[int]) -> Metrics:
    """Return all counters, since the start and for the last seconds."""
    counted = service.metrics
    before, now = counted.recent(), counted.sample()
    window = max(now.wall - before.wall, 1e-6)
    commands = counted.command_times.keys() | counted.failures.keys()
    return {
        **health(service, realm),
        "host": socket.gethostname(),
        "process_id": os.getpid(),
        "ports": list(ports),
        "scene": service.simulation.scene.name,
        "window": window,
        "steps": _steps(service, before, now, window),
        "calls": {**_calls(before, now, window), "dropped": counted.dropped},
        "commands": {name: _command(service, name, before, window) for name in sorted(commands)},
        "clients": [
            _client(service, session, before, window) for session in service.clients.sessions.values()
        ],
        "departed": [_departed(service, each) for each in service.clients.departed],
        "streams": sum(len(session.streams.by_id) for session in service.clients.sessions.values()),
        "images": _images(service, before, window),
        "process": _process(before, now, window),
        "log": {
            "warnings": counted.log.warnings,
            "errors": counted.log.errors,
            "last_warning": counted.log.last_warning,
            "last_error": counted.log.last_error,
        },
    }


def _problems(service: Service) -> list[str]:
    counted = service.metrics
    before, now = counted.recent(), counted.sample()
    window = f"{now.wall - before.wall:.0f} s"
    found: list[str] = []
    if busy := service.busy.describe():
        found.append(busy)
    if (lost := now.lost - before.lost) > 0:
        found.append(
            f"the simulation cannot keep up with speed {counted.pacer.speed:g}: "
            f"{lost:.2f} s of the last {window} are lost"
        )
    if failed := now.images_failed - before.images_failed:
        found.append(f"{failed} images of the last {window} failed: {counted.images.last_error}")
    if errors := now.errors - before.errors:
        found.append(f"{errors} errors were logged in the last {window}: {counted.log.last_error}")
    return found


def _steps(service: Service, before: Sample, now: Sample, window: float) -> Steps:
    counted = service.metrics
    speed = counted.pacer.speed
    return {
        "count": now.steps,
        "per_second": (now.steps - before.steps) / window,
        "simulated": now.simulated,
        "real_time_factor": (now.simulated - before.simulated) / window,
        "speed": speed if speed < float("inf") else None,
        "time_step": service.simulation.time_step,
        "lost": now.lost,
        "times": _timing(counted.step_times, before.step_times, window),
    }


def _calls(before: Sample, now: Sample, window: float) -> Calls:
    return {
        "count": now.calls,
        "per_second": (now.calls - before.calls) / window,
        "failed": now.failed,
        "failed_per_second": (now.failed - before.failed) / window,
    }


def _timing(times: Histogram, before: Sequence[int], window: float) -> Timing:
    counts = list(times.counts)
    recent = list(map(sub, counts, before)) if before else counts
    return {
        "count": sum(counts),
        "seconds": times.seconds,
        "longest": times.longest,
        **_percentiles(counts, times.longest),
        "recent": {"per_second": sum(recent) / window, **_percentiles(recent, times.longest)},
    }


def _percentiles(counts: Sequence[int], longest: float) -> Percentiles:
    p50, p90, p99 = (min(seconds, longest) for seconds in percentiles(counts))
    return {"p50": p50, "p90": p90, "p99": p99}


def _timings(
    times: Mapping[str, Histogram], name: str, before: Mapping[str, list[int]], window: float
) -> Timing:
    return _timing(times.get(name) or Histogram(), before.get(name, []), window)


def _command(service: Service, name: str, before: Sample, window: float) -> Command:
    counted = service.metrics
    failures = counted.failures.get(name) or Failures()
    return {
        **_timings(counted.command_times, name, before.command_times, window),
        "failed": failures.failed,
        "silent": failures.silent,
        "internal": failures.internal,
        "last_error": failures.last,
    }


def _client(service: Service, session: ClientSession, before: Sample, window: float) -> Client:
    calls = service.metrics.client_calls.get(session.client, 0)
    return {
        "name": session.name,
        "role": "viewer" if session.may_only_read else "driver",
        "port": session.port,
        "calls": calls,
        "calls_per_second": (calls - before.client_calls.get(session.client, 0)) / window,
        "streams": len(session.streams.by_id),
        "is_stepping": session.is_stepping,
        "commands": dict(session.called),
    }


def _departed(service: Service, departed: Departed) -> DepartedClient:
    return {
        "name": departed.name,
        "role": "viewer" if departed.may_only_read else "driver",
        "port": departed.port,
        "calls": departed.calls,
        "commands": dict(departed.called),
        "ago": service.metrics.age - departed.left_at,
    }


def _images(service: Service, before: Sample, window: float) -> Images:
    images = service.metrics.images
    rendering: RenderThread | None = service.world.rendering
    backend = rendering.backend if rendering else None
    return {
        "backend": backend.name if backend else None,
        "waiting": rendering.waiting if rendering else 0,
        "failed": images.failed,
        "last_error": images.last_error,
        "cameras": {
            name: _timings(images.by_camera, name, before.image_times, window)
            for name in sorted(images.by_camera.copy())
        },
    }


def _process(before: Sample, now: Sample, window: float) -> Process:
    descriptors = Path("/proc/self/fd")
    return {
        "memory": _memory(),
        "open_files": len(os.listdir(descriptors)) if descriptors.is_dir() else None,
        "threads": threading.active_count(),
        "processor_seconds": time.process_time(),
        "core_share": (now.processor - before.processor) / window,
    }


def _memory() -> int:
    """Return the resident bytes: present ones on Linux, the most so far on other Unix systems; 0 on Windows."""
    statistics = Path("/proc/self/statm")
    if statistics.is_file():
        return int(statistics.read_text(encoding="ascii").split()[1]) * mmap.PAGESIZE
    if sys.platform == "win32":
        return 0
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else most * 1024
