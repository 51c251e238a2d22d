"""The metrics of a server as text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from simx_client.cli.listing import NO_ANSWER, age
from simx_client.connection.discovery import Measured
from simx_client.protocol.reports import Metrics, Timing

COMMANDS_SHOWN = 15
"""Number of commands shown, those that took the most time."""

ERRORS_SHOWN = 5
TEXT_SHOWN = 110
"""Maximum number of characters of an error."""


def description(server: Measured) -> list[str]:
    """Return the lines about one server."""
    metrics = server.metrics
    if metrics is None:
        return [
            f"{server.realm}  {NO_ANSWER} at {server.endpoint}: frozen, busy with one long call, or cut off"
        ]
    return [
        f"{server.realm}  {metrics['state']}  scene {metrics['scene']}  up {age(metrics['age'])}  "
        f"{metrics['host']} pid {metrics['process_id']}  simx {metrics['server']}",
        *_summary(metrics),
        *_clients(metrics),
        *_commands(metrics),
        *_cameras(metrics),
        *_errors(metrics),
    ]


def _summary(metrics: Metrics) -> Iterator[str]:
    steps, calls, images = metrics["steps"], metrics["calls"], metrics["images"]
    process, log = metrics["process"], metrics["log"]
    window = f"last {metrics['window']:.0f} s"
    problems = metrics["problems"] or ["good"]
    yield f"  health    {problems[0]}"
    for problem in problems[1:]:
        yield f"            {problem}"
    speed = "max" if steps["speed"] is None else f"{steps['speed']:g} x"
    p50, p99 = _percentiles(steps["times"])
    yield (
        f"  steps     {steps['per_second']:.1f} /s, {steps['real_time_factor']:.2f} x real time ({window}; asked: "
        f"{speed}); each of {steps['time_step'] * 1000:g} ms takes {duration(p50)} (p50), {duration(p99)} (p99); "
        f"{steps['lost']:.2f} s lost"
    )
    yield (
        f"  calls     {calls['per_second']:.1f} /s, {calls['count']} in all, {calls['failed']} failed; "
        f"{metrics['streams']} streams"
    )
    if images["cameras"] or images["waiting"] or images["failed"]:
        yield (
            f"  images    made with {images['backend'] or 'nothing yet'}, {images['waiting']} waiting, "
            f"{images['failed']} failed"
        )
    files = "" if process["open_files"] is None else f", {process['open_files']} open files"
    yield (
        f"  process   {process['memory'] / 1e6:.0f} MB{files}, {process['threads']} threads, "
        f"{process['core_share']:.0%} of a core"
    )
    yield f"  log       {log['warnings']} warnings, {log['errors']} errors"


def _clients(metrics: Metrics) -> list[str]:
    return _table(
        ("CLIENT", "ROLE", "PORT", "CALLS/S", "CALLS", "STREAMS", "STEPS"),
        [
            (
                client["name"],
                client["role"],
                str(client["port"]),
                f"{client['calls_per_second']:.1f}",
                str(client["calls"]),
                str(client["streams"]),
                "yes" if client["is_stepping"] else "no",
            )
            for client in metrics["clients"]
        ],
    )


def _commands(metrics: Metrics) -> list[str]:
    by_time = sorted(metrics["commands"].items(), key=lambda item: -item[1]["seconds"])
    rows = [
        (*_timing_cells(name, command), str(command["failed"])) for name, command in by_time[:COMMANDS_SHOWN]
    ]
    lines = _table((*_timing_head("COMMAND"), "FAILED"), rows)
    if len(by_time) > COMMANDS_SHOWN:
        lines.append(f"  and {len(by_time) - COMMANDS_SHOWN} more that took less time; --json has them all")
    return lines


def _cameras(metrics: Metrics) -> list[str]:
    cameras: Mapping[str, Timing] = metrics["images"]["cameras"]
    return _table(_timing_head("CAMERA"), [_timing_cells(name, times) for name, times in cameras.items()])


def _errors(metrics: Metrics) -> Iterator[str]:
    failed = {name: each for name, each in metrics["commands"].items() if each["last_error"]}
    worst = sorted(failed.items(), key=lambda item: -item[1]["failed"])[:ERRORS_SHOWN]
    texts = [f"{command['failed']} x {command['last_error']}" for _, command in worst]
    texts += [f"image: {error}" for error in [metrics["images"]["last_error"]] if error]
    texts += [
        f"log: {text}" for text in (metrics["log"]["last_error"], metrics["log"]["last_warning"]) if text
    ]
    if texts:
        yield ""
        yield "  LATEST ERRORS"
        for text in texts:
            line = " ".join(text.split())
            yield f"  {line if len(line) <= TEXT_SHOWN else line[: TEXT_SHOWN - 3] + '...'}"


def _timing_head(what: str) -> tuple[str, ...]:
    return (what, "/S", "COUNT", "P50", "P90", "P99", "LONGEST")


def _timing_cells(name: str, times: Timing) -> tuple[str, ...]:
    """Return percentiles of recent times, else of those since the start."""
    recent = times["recent"]
    chosen = recent if recent["per_second"] else times
    return (
        name,
        f"{recent['per_second']:.1f}",
        str(times["count"]),
        duration(chosen["p50"]),
        duration(chosen["p90"]),
        duration(chosen["p99"]),
        duration(times["longest"]),
    )


def _percentiles(times: Timing) -> tuple[float, float]:
    chosen = times["recent"] if times["recent"]["per_second"] else times
    return chosen["p50"], chosen["p99"]


def duration(seconds: float) -> str:
    """Format a duration in a suitable unit."""
    if 0 < seconds < 1e-3:
        return f"{seconds * 1e6:.3g} us"
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table: first column left-aligned, the others right-aligned; empty without rows."""
    if not rows:
        return []
    lines = [head, *rows]
    widths = [max(len(row[column]) for row in lines) for column in range(len(head))]
    return ["", *("  " + "  ".join(_cells(row, widths)).rstrip() for row in lines)]


def _cells(row: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    for column, (cell, width) in enumerate(zip(row, widths, strict=True)):
        yield cell.rjust(width) if column else cell.ljust(width)
