"""Show who is connected, what they call, how long that takes, and recent errors."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

import viser

from simx_client.cli.listing import age
from simx_client.cli.status.text import duration
from simx_client.protocol.reports import Client, DepartedClient, Metrics, Timing
from simx_server.viewer.messages import OWN_NAME, Look, StreamView, Survey

from .elements import harmless, put

EVERY = 1.0
"""Seconds between two updates: the server's figures are not newer."""

_COMMANDS = 20
"""Commands that are shown: those called most often in the last seconds, then those that took the most time."""

_BY_CLIENT = 6
"""Commands and streams of one client that are shown."""

_LEFT = 5
"""Clients that have left and are still shown."""

_ERRORS = 5
_LETTERS = 300
_BLOCK = "padding:0 0.75em 0.75em;font-size:0.85em;overflow-x:auto"
_CELL = "padding:0.1em 0.4em 0.1em 0;overflow-wrap:anywhere"
_NUMBER = f"{_CELL};text-align:right;white-space:nowrap"


class Clients:
    """Tables. The viewer's own clients are listed separately, because only the viewer causes their calls."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._next = 0.0
        self._before: dict[tuple[str, int], dict[str, int]] = {}
        self._before_at = 0.0
        """The time when `_before`, the calls of each client, was stored; in the server's age."""

        self._rates: dict[tuple[str, int], dict[str, float]] = {}
        self._summary = gui.add_html("")
        with gui.add_folder("Clients"):
            self._clients = gui.add_html("")
        with gui.add_folder("Calls and streams"):
            self._commands = gui.add_html("")
        with gui.add_folder("Images") as self._images_folder:
            self._images = gui.add_html("")
        with gui.add_folder("Latest errors and warnings") as self._errors_folder:
            self._errors = gui.add_html("")

    def update(self, survey: Survey, look: Look) -> None:
        """Update the tables."""
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + EVERY
        metrics = survey["metrics"]
        self._count(metrics)
        own = [each for each in metrics["clients"] if each["name"].startswith(OWN_NAME)]
        others = [each for each in metrics["clients"] if not each["name"].startswith(OWN_NAME)]
        put(self._summary, content=_block(_summary(metrics)))
        left = [each for each in metrics.get("departed", []) if not each["name"].startswith(OWN_NAME)]
        put(self._clients, content=_block(self._who(others, own, survey["streams"]) + _gone(left)))
        put(
            self._commands, content=_block(_commands(metrics, _called(own) - _called(others) - _called(left)))
        )
        cameras = metrics["images"]["cameras"]
        put(self._images_folder, visible=bool(cameras))
        put(self._images, content=_block(_times("camera", cameras)))
        errors = "".join(f"<p>{harmless(each, _LETTERS)}</p>" for each in _errors(metrics))
        put(self._errors_folder, visible=bool(errors))
        put(self._errors, content=_block(errors))

    def close(self) -> None:
        """Do nothing."""

    def _count(self, metrics: Metrics) -> None:
        """Compute how often each client has called each command recently, as the server returns only totals."""
        if metrics["age"] < self._before_at:  # another server
            self._before, self._rates, self._before_at = {}, {}, 0.0
        passed = metrics["age"] - self._before_at
        if self._before and passed < metrics["window"] / 2:
            return
        called = {key: dict(each.get("commands", {})) for key, each in _keyed(metrics["clients"])}
        self._rates = {
            key: {name: (count - self._before[key].get(name, 0)) / passed for name, count in counts.items()}
            for key, counts in called.items()
            if key in self._before
        }
        self._before, self._before_at = called, metrics["age"]

    def _who(self, others: Sequence[Client], own: Sequence[Client], streams: Sequence[StreamView]) -> str:
        streamed: defaultdict[str, list[str]] = defaultdict(list)
        for stream in streams:
            streamed[stream["client"]].append(f"{stream['command']}({stream['arguments']})")
        shown = "".join(self._client(key, each, streamed[each["name"]]) for key, each in _keyed(others))
        rate = sum(each["calls_per_second"] for each in own)
        return (
            shown or "<p>No program is connected.</p>"
        ) + f"<p style='opacity:0.7'>This page itself: {len(own)} clients, {rate:.0f} calls/s.</p>"

    def _client(self, key: tuple[str, int], client: Client, streams: Sequence[str]) -> str:
        words = [client["role"], f"port {client['port']}", f"{client['calls_per_second']:.1f} calls/s"]
        words += [f"{client['calls']} in all", f"{client['streams']} streams"]
        if client["is_stepping"]:
            words.append("<b>steps the simulation</b>")
        rates = self._rates.get(key, {})
        counts = client.get("commands", {})
        often = sorted(counts, key=lambda name: (-rates.get(name, 0.0), -counts[name]))
        late = {name: f" ({rate:.1f}/s)" for name, rate in rates.items() if rate > 0}
        calls = [f"{harmless(name)} {counts[name]}{late.get(name, '')}" for name in often]
        return (
            f"<p style='margin:0 0 0.6em'><b>{harmless(client['name'], 60)}</b>: {', '.join(words)}"
            f"{_few('calls', calls)}{_few('streams', [harmless(each, 120) for each in streams])}</p>"
        )


def _gone(left: Sequence[DepartedClient]) -> str:
    """Return clients that have left, the newest first, with what they called."""
    shown = [
        f"<p style='margin:0 0 0.6em;opacity:0.5'><b>{harmless(each['name'], 60)}</b>: left {age(each['ago'])} ago, "
        f"{each['role']}, port {each['port']}, {each['calls']} calls in all"
        f"{_few('calls', _by_count(each['commands']))}</p>"
        for each in left[: -_LEFT - 1 : -1]
    ]
    if len(left) > _LEFT:
        shown.append(f"<p style='opacity:0.5'>and {len(left) - _LEFT} more that have left</p>")
    return "".join(shown)


def _by_count(counts: Mapping[str, int]) -> list[str]:
    """Return names of commands with how often they were called, the most frequent first."""
    return [f"{harmless(name)} {counts[name]}" for name in sorted(counts, key=lambda name: -counts[name])]


def _keyed(clients: Sequence[Client]) -> Iterator[tuple[tuple[str, int], Client]]:
    """Yield each client with its name and its number among those with that name, in the order they joined."""
    seen: defaultdict[str, int] = defaultdict(int)
    for client in clients:
        yield (client["name"], seen[client["name"]]), client
        seen[client["name"]] += 1


def _summary(metrics: Metrics) -> str:
    steps, calls = metrics["steps"], metrics["calls"]
    speed = "as fast as it goes" if steps["speed"] is None else f"{steps['speed']:g} × asked"
    times = _of_late(steps["times"])
    lines = [
        f"{steps['real_time_factor']:.2f} × real time ({speed}), {steps['per_second']:.1f} steps/s",
        f"a step takes {duration(times['p50'])} (p50), {duration(times['p99'])} (p99)",
        f"{calls['per_second']:.0f} calls/s, {metrics['streams']} streams, {calls['failed']} failed",
        f"{metrics['process']['memory'] / 1e6:.0f} MB, {metrics['process']['core_share']:.0%} of a core",
        *(f"<b>{harmless(problem, _LETTERS)}</b>" for problem in metrics["problems"]),
    ]
    return "<br>".join(lines)


def _called(clients: Sequence[Client] | Sequence[DepartedClient]) -> set[str]:
    return {name for client in clients for name in client.get("commands", {})}


def _commands(metrics: Metrics, own: set[str]) -> str:
    """Return a table of all commands but `own`, those that the viewer alone calls."""
    commands = {name: each for name, each in metrics["commands"].items() if name not in own}
    busiest = sorted(
        commands, key=lambda name: (-commands[name]["recent"]["per_second"], -commands[name]["seconds"])
    )
    chosen = {name: commands[name] for name in busiest[:_COMMANDS]}
    text = _times("command", chosen, {name: str(each["failed"]) for name, each in chosen.items()})
    if len(busiest) > _COMMANDS:
        text += f"<p>and {len(busiest) - _COMMANDS} more; <code>simx status --json</code> has them all</p>"
    return text or "<p>No program has called anything yet.</p>"


def _times(what: str, timings: Mapping[str, Timing], failed: Mapping[str, str] | None = None) -> str:
    """Return a table of how often and how long; empty for none."""
    if not timings:
        return ""
    head = [what, "/s", "count", "p50", "p99", *(["failed"] if failed is not None else [])]
    rows = [
        "".join(f"<th style='{_NUMBER if index else _CELL}'>{each}</th>" for index, each in enumerate(head))
    ]
    for name, times in timings.items():
        late = _of_late(times)
        cells = [f"{times['recent']['per_second']:.1f}", str(times["count"])]
        cells += [duration(late["p50"]), duration(late["p99"])]
        if failed is not None:
            cells.append(failed[name])
        numbers = "".join(f"<td style='{_NUMBER}'>{cell}</td>" for cell in cells)
        rows.append(f"<td style='{_CELL}'>{harmless(name)}</td>{numbers}")
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return f"<table style='border-collapse:collapse;text-align:left'>{body}</table>"


def _of_late(times: Timing) -> Mapping[str, float]:
    """Return recent percentiles, else those since the start; seconds."""
    chosen = times["recent"] if times["recent"]["per_second"] else times
    return {"p50": chosen["p50"], "p99": chosen["p99"]}


def _errors(metrics: Metrics) -> Iterator[str]:
    log, images = metrics["log"], metrics["images"]
    if log["last_error"]:
        yield f"{log['errors']} errors in the log, the last: {log['last_error']}"
    if log["last_warning"]:
        yield f"{log['warnings']} warnings in the log, the last: {log['last_warning']}"
    if images["last_error"]:
        yield f"{images['failed']} images failed, the last: {images['last_error']}"
    failed = [each for each in metrics["commands"].values() if each["last_error"]]
    for each in sorted(failed, key=lambda each: -each["failed"])[:_ERRORS]:
        yield f"{each['failed']} × {each['last_error']}"


def _few(what: str, texts: Sequence[str]) -> str:
    """Return the first few of some texts of HTML, on a separate line."""
    if not texts:
        return ""
    more = f" and {len(texts) - _BY_CLIENT} more" if len(texts) > _BY_CLIENT else ""
    return f"<br><span style='opacity:0.8'>{what}: {', '.join(texts[:_BY_CLIENT])}{more}</span>"


def _block(content: str) -> str:
    return f"<div style='{_BLOCK}'>{content}</div>"
