"""What was found, and the two pages that say it: a summary of one page, and a section for each measurement."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from .bars import Bar, Bars
from .measure import Rounds

PLOTS = "plots"
"""The folder beside the page with its images."""

DETAILS, PROFILES = "DETAILS.md", "PROFILES.md"
"""The other pages: `details`, and what `python -m bench.profiles` writes."""

Curve = Sequence[tuple[float, float]]
"""Points (x, y), both above zero, by rising x."""


@dataclass(frozen=True)
class Ratio:
    """Something in relation to its baseline, or to a bound it should keep."""

    what: str
    value: float
    unit: str = "x"
    target: float | None = None
    """At most so much; None when it is only told."""

    @property
    def is_kept(self) -> bool:
        """Return whether the value is at most the target."""
        return self.target is not None and self.value <= self.target

    @property
    def verdict(self) -> str:
        """Return the word for the table."""
        if self.target is None:
            return ""
        return "yes" if self.is_kept else "**no**"


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


@dataclass(frozen=True)
class Grid:
    """Figures by something counted: a line for each count or name, a column for each figure."""

    head: Sequence[str]
    lines: Sequence[tuple[str, Sequence[float | None]]]
    """Name and figures; None where there is none."""


@dataclass(frozen=True)
class Panel:
    """One diagram. The x axis is logarithmic: sizes are doubled."""

    title: str
    x: str
    curves: Mapping[str, Curve]
    baselines: Mapping[str, Curve]
    """Drawn in grey: the cheapest thing that does the same work, or nothing at all."""

    is_log: bool = False
    """The y axis too."""


@dataclass(frozen=True)
class Plot:
    """Panels side by side, one image."""

    name: str
    """Of the file, without its suffix."""

    panels: Sequence[Panel]


@dataclass(frozen=True)
class Rival:
    """One line of the summary's table of rivals: a task, and what it takes each of those who can do it."""

    task: str
    """With its unit."""

    figures: Mapping[str, float]
    """By the name of the rival; names that begin with `OURS` are this project's."""


OURS = "simx"


@dataclass
class Findings:
    """What one measurement brought."""

    title: str
    topic: str = "Other"
    """Under what its aims stand in the summary."""

    ratios: list[Ratio] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    grids: list[Grid] = field(default_factory=list)
    plots: list[Plot] = field(default_factory=list)
    rivals: list[Rival] = field(default_factory=list[Rival])


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


def compose(
    findings: Sequence[Findings],
    *,
    conditions: Sequence[str],
    others: Mapping[str, Mapping[str, float]] | None = None,
) -> str:
    """Return the summary: what was kept by topic, the rivals, all aims by topic, the conditions.

    Args:
        conditions: what is said of the machine and the run, a line each.
        others: figures of aims by their names, from runs at other paces of the machine; a column for each.
    """
    others = others or {}
    aims: dict[str, list[Ratio]] = {}
    for found in findings:
        aims.setdefault(found.topic, []).extend(each for each in found.ratios if each.target is not None)
    aims = {topic: each for topic, each in aims.items() if each}
    lines = [
        "# What simx costs",
        "",
        "Aims are ratios to a baseline of the same run. A ratio of Python to C differs between machines; "
        "counts do not (`python -m bench.counts`).",
    ]
    lines += [
        f"Figures and what is not an aim: [{DETAILS}]({DETAILS}); where the time goes: [{PROFILES}]({PROFILES}).",
        "",
    ]
    lines += _rivals([rival for found in findings for rival in found.rivals])
    if aims:
        lines += ["", "## Aims", "", *_kept(aims)]
        for topic, each in aims.items():
            rows = [
                (
                    aim.what,
                    _with_unit(aim.value, aim),
                    _with_unit(aim.target, aim),
                    aim.verdict,
                    *(_with_unit(found.get(aim.what), aim) for found in others.values()),
                )
                for aim in each
            ]
            lines += ["", f"### {topic}", "", *table(("what", "found", "at most", "kept", *others), rows)]
    lines += ["", "## Conditions", "", *(f"- {condition}" for condition in conditions)]
    return "\n".join(lines) + "\n"


def details(findings: Sequence[Findings], *, conditions: Sequence[str]) -> str:
    """Return the page with all figures, a section for each measurement."""
    lines = ["# What simx costs, in detail", "", "The [report](REPORT.md) has the aims.", ""]
    lines += [*(f"- {condition}" for condition in conditions), ""]
    lines += [
        "Each figure was taken beside its baseline in the same minutes, in short rounds by turns. A figure is the",
        "median of the rounds' medians (p99: of their 99th percentiles), a ratio the median of the rounds' ratios.",
        "Ratios hold on other machines too; figures do not.",
        "",
        "Sections: " + ", ".join(f"[{found.title}](#{_anchor(found.title)})" for found in findings),
    ]
    for found in findings:
        lines += _section(found)
    return "\n".join(lines) + "\n"


def _kept(aims: Mapping[str, Sequence[Ratio]]) -> list[str]:
    every = [aim for each in aims.values() for aim in each]
    rows = [
        (topic, f"{sum(aim.is_kept for aim in each)} of {len(each)}", _worst(each))
        for topic, each in aims.items()
    ]
    return [
        f"{sum(aim.is_kept for aim in every)} of {len(every)} are kept.",
        "",
        *table(("topic", "kept", "furthest from its aim, as a share of what is allowed"), rows),
    ]


def _worst(aims: Sequence[Ratio]) -> str:
    worst = max(aims, key=lambda aim: aim.value / (aim.target or 1.0))
    return f"{worst.what}: {number(worst.value / (worst.target or 1.0))}"


def _rivals(rivals: Sequence[Rival]) -> list[str]:
    if not rivals:
        return []
    names = list(dict.fromkeys(name for rival in rivals for name in rival.figures))
    rows = [
        (name, *(number(rival.figures[name]) if name in rival.figures else "" for rival in rivals))
        for name in names
    ]
    return [
        "## Rivals",
        "",
        f"![rivals]({PLOTS}/rivals.png)",
        "",
        *table(("", *(rival.task for rival in rivals)), rows),
    ]


def bars_of(findings: Sequence[Findings]) -> Bars | None:
    """Return the plot of the rivals; None if they were not measured."""
    groups = [
        (rival.task, [Bar(name, value, name.startswith(OURS)) for name, value in rival.figures.items()])
        for found in findings
        for rival in found.rivals
    ]
    return Bars("rivals", groups) if groups else None


def _section(found: Findings) -> list[str]:
    parts: list[list[str]] = [[f"![{plot.name}]({PLOTS}/{plot.name}.png)"] for plot in found.plots]
    for grid in found.grids:
        cells = [
            (name, *("" if value is None else number(value) for value in values))
            for name, values in grid.lines
        ]
        parts.append(table(grid.head, cells))
    if beside := [ratio for ratio in found.ratios if ratio.target is None]:
        parts.append(
            table(
                ("beside its baseline", "ratio"),
                [(each.what, _with_unit(each.value, each)) for each in beside],
            )
        )
    if found.rows:
        figures = [
            (row.what, number(row.median), "" if row.p99 is None else number(row.p99), row.unit)
            for row in found.rows
        ]
        parts.append(table(("what", "median", "p99", "unit"), figures))
    if found.notes:
        parts.append([f"- {note}" for note in found.notes])
    lines = ["", f"## {found.title}"]
    for part in parts:
        lines += ["", *part]
    return lines


def _with_unit(value: float | None, ratio: Ratio) -> str:
    return "" if value is None else f"{number(value)} {ratio.unit}"


def _anchor(title: str) -> str:
    """As the usual sites make it of a heading."""
    return re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
