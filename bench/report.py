"""What was found, and the page that says it: ratios first, since they hold on other machines too."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .measure import Rounds

PACKAGES = ("mujoco", "eclipse-zenoh", "numpy", "msgpack")


@dataclass(frozen=True)
class Ratio:
    """Something in relation to its baseline, or to a bound it should keep."""

    what: str
    value: float
    unit: str = "x"
    target: float | None = None
    """At most so much; None when it is only told."""

    @property
    def verdict(self) -> str:
        if self.target is None:
            return ""
        return "yes" if self.value <= self.target else "**no**"


@dataclass(frozen=True)
class Row:
    """One figure: median and 99th percentile in the given unit."""

    what: str
    median: float
    p99: float | None
    unit: str

    @classmethod
    def of(cls, what: str, rounds: Rounds, unit: str) -> Row:
        """From seconds."""
        scale = {"us": 1e6, "ms": 1e3, "s": 1.0}[unit]
        has_tail = rounds.count > 2 * len(rounds.values)
        return cls(what, rounds.median * scale, rounds.p99 * scale if has_tail else None, unit)


@dataclass
class Findings:
    """What one measurement brought."""

    title: str
    ratios: list[Ratio] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def number(value: float) -> str:
    """Three digits that mean something."""
    if value >= 100:
        return f"{value:,.0f}"
    return f"{value:.1f}" if value >= 10 else f"{value:.2f}"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A Markdown table whose columns also line up in a terminal; all but the first are right-aligned."""
    widths = [max(len(line[column]) for line in (head, *rows)) for column in range(len(head))]

    def line(cells: Sequence[str]) -> str:
        first, *others = [
            cell.ljust(width) if column == 0 else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        return "| " + " | ".join([first, *others]) + " |"

    rule = "|" + "|".join(
        "-" * (width + 2) if column == 0 else "-" * (width + 1) + ":" for column, width in enumerate(widths)
    )
    return [line(head), rule + "|", *map(line, rows)]


def machine() -> list[str]:
    """Where and with what: processor, cores, system, versions, date."""
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)
    return [
        f"- {datetime.datetime.now(datetime.UTC):%Y-%m-%d %H:%M} UTC, {_processor()}, {os.cpu_count()} cores, "
        f"{platform.system()} {'.'.join(platform.release().split('.')[:2])}",
        f"- Python {platform.python_version()}, {versions}",
        f"- load average when it ended: {', '.join(f'{load:.1f}' for load in os.getloadavg())}",
    ]


def _processor() -> str:
    information = Path("/proc/cpuinfo")
    if information.is_file():
        for line in information.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def compose(findings: Sequence[Findings], *, effort: str) -> str:
    """The page."""
    lines = ["# What simx costs", "", *machine(), f"- {effort}", ""]
    lines += [
        "Each figure was taken beside its baseline in the same minutes, in short rounds by turns. A figure is the",
        "median of the rounds' medians (p99: of their 99th percentiles), a ratio the median of the rounds' ratios.",
        "",
        "## Ratios and targets",
        "",
    ]
    ratios = [
        (ratio.what, f"{number(ratio.value)} {ratio.unit}", _bound(ratio), ratio.verdict)
        for found in findings
        for ratio in found.ratios
    ]
    lines += table(("what", "found", "at most", "kept"), ratios)
    for found in findings:
        lines += ["", f"## {found.title}", ""]
        rows = [
            (row.what, number(row.median), "" if row.p99 is None else number(row.p99), row.unit)
            for row in found.rows
        ]
        lines += table(("what", "median", "p99", "unit"), rows)
        lines += ["", *(f"- {note}" for note in found.notes)] if found.notes else []
    return "\n".join(lines) + "\n"


def _bound(ratio: Ratio) -> str:
    return "" if ratio.target is None else f"{number(ratio.target)} {ratio.unit}"
