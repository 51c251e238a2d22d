"""Metrics in Prometheus' text format, for its textfile collector: no port is opened.

The format: https://prometheus.io/docs/instrumenting/exposition_formats/
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from simx_client.connection.discovery import Measured
from simx_client.protocol.reports import Metrics, Timing

_Value = Callable[[Metrics], float | None]

SINGLE: tuple[tuple[str, str, str, _Value], ...] = (
    ("age_seconds", "gauge", "Since the server was started.", lambda m: m["age"]),
    ("problems", "gauge", "What has gone wrong in recent seconds.", lambda m: len(m["problems"])),
    ("steps_total", "counter", "Simulation steps as clients see them.", lambda m: m["steps"]["count"]),
    ("simulated_seconds_total", "counter", "Simulated time.", lambda m: m["steps"]["simulated"]),
    ("real_time_factor", "gauge", "Recent.", lambda m: m["steps"]["real_time_factor"]),
    ("lost_seconds_total", "counter", "Wall time the simulation fell behind.", lambda m: m["steps"]["lost"]),
    ("calls_total", "counter", "Calls of clients.", lambda m: m["calls"]["count"]),
    ("clients", "gauge", "Clients that are there.", lambda m: len(m["clients"])),
    ("streams", "gauge", "Armed streams.", lambda m: m["streams"]),
    ("images_waiting", "gauge", "Images not started.", lambda m: m["images"]["waiting"]),
    ("images_failed_total", "counter", "Images not made.", lambda m: m["images"]["failed"]),
    ("resident_memory_bytes", "gauge", "Of the process.", lambda m: m["process"]["memory"]),
    ("open_fds", "gauge", "Of the process.", lambda m: m["process"]["open_files"]),
    ("cpu_seconds_total", "counter", "Of the process.", lambda m: m["process"]["processor_seconds"]),
    ("log_warnings_total", "counter", "Logged warnings.", lambda m: m["log"]["warnings"]),
    ("log_errors_total", "counter", "Logged errors.", lambda m: m["log"]["errors"]),
)


def exposition(servers: Sequence[Measured]) -> str:
    """Return one text for all servers, each with its realm and host as labels."""
    return "".join(f"{line}\n" for line in _lines(servers))


def _lines(servers: Sequence[Measured]) -> Iterator[str]:
    yield from _head("up", "gauge", "Whether the server answers.")
    for server in servers:
        host = server.metrics["host"] if server.metrics else ""
        yield _sample("up", {"realm": server.realm, "host": host}, server.metrics is not None)
    measured = [server.metrics for server in servers if server.metrics is not None]
    for name, kind, help_text, value_of in SINGLE:
        yield from _head(name, kind, help_text)
        for metrics in measured:
            if (value := value_of(metrics)) is not None:
                yield _sample(name, _of(metrics), value)
    yield from _head("step_seconds", "summary", "Of one simulation step, without streams and calls.")
    for metrics in measured:
        yield from _summary("step_seconds", _of(metrics), metrics["steps"]["times"])
    yield from _head("command_seconds", "summary", "On the simulating thread, for calls and streams.")
    for metrics in measured:
        for name, command in metrics["commands"].items():
            yield from _summary("command_seconds", {**_of(metrics), "command": name}, command)
    yield from _head("failed_total", "counter", "Calls and streams that ended in an error.")
    for metrics in measured:
        for name, command in metrics["commands"].items():
            yield _sample("failed_total", {**_of(metrics), "command": name}, command["failed"])
    yield from _head("image_seconds", "summary", "On the render thread.")
    for metrics in measured:
        for name, times in metrics["images"]["cameras"].items():
            yield from _summary("image_seconds", {**_of(metrics), "camera": name}, times)


def _of(metrics: Metrics) -> dict[str, str]:
    return {"realm": metrics["realm"], "host": metrics["host"]}


def _head(name: str, kind: str, help_text: str) -> Iterator[str]:
    yield f"# HELP simx_{name} {help_text}"
    yield f"# TYPE simx_{name} {kind}"


def _summary(name: str, labels: Mapping[str, str], times: Timing) -> Iterator[str]:
    """Yield a summary with quantiles of recent times; NaN without any."""
    recent = times["recent"]
    for share, seconds in (("0.5", recent["p50"]), ("0.9", recent["p90"]), ("0.99", recent["p99"])):
        value = seconds if recent["per_second"] else float("nan")
        yield _sample(name, {**labels, "quantile": share}, value)
    yield _sample(f"{name}_sum", labels, times["seconds"])
    yield _sample(f"{name}_count", labels, times["count"])


def _sample(name: str, labels: Mapping[str, str], value: float) -> str:
    inside = ",".join(f'{label}="{_escaped(text)}"' for label, text in labels.items())
    return f"simx_{name}{{{inside}}} {value:.10g}".replace(" nan", " NaN")


def _escaped(text: str) -> str:
    return text.replace("\\", r"\\").replace('"', r"\"").replace("\n", r"\n")
