"""The page of a comparison: one HTML file with the result and the plots, which needs nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from .departures import Comparison, Departure
from .plots import plot
from .quantities import ORIENTATION, POSITION, UNITS
from .text import Names, first_of_each, lines, size_text
from .trajectories import Run

MOST_PLOTS = 24

_LABELS = {POSITION: ("x", "y", "z"), ORIENTATION: ("w", "x", "y", "z")}

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; width: 100%; } td, th { padding: .2rem .6rem; text-align: left;
border-bottom: 1px solid #ddd; } td.number { text-align: right; font-variant-numeric: tabular-nums; }
pre { background: #f6f6f4; padding: .8rem; overflow-x: auto; white-space: pre-wrap; }
svg { width: 100%; height: auto; background: #fcfcfb; } svg text { font: 11px system-ui, sans-serif; fill: #555; }
svg .grid { stroke: #e4e4e0; } svg .mark { stroke: #c80; stroke-dasharray: 3 3; }
svg polyline { fill: none; stroke-width: 1.4; } svg polyline.other { stroke-dasharray: 5 4; }
@media (prefers-color-scheme: dark) { body { background: #1b1c1e; color: #ddd; } pre { background: #26272a; }
td, th { border-color: #3a3b3f; } svg { background: #222326; } svg text { fill: #aaa; } svg .grid { stroke: #35363a; } }
"""


def page(title: str, found: Comparison, runs: tuple[Run, Run], names: Names, *, steps: bool = True) -> str:
    """Return the page as HTML."""
    shown = [*found.departures, *found.equal]
    plots = [_section(each, runs, names) for each in _most_telling(found)]
    text = "\n".join(lines(found, names, steps=steps))
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title><style>{_STYLE}</style></head><body>
<h1>{escape(title)}</h1>
<pre>{escape(text)}</pre>
<h2>Plots</h2>
<p>Solid: {escape(names.one)}. Dashed: {escape(names.other)}.
The vertical line is the first time above the tolerance.</p>
{"".join(plots)}
<h2>All quantities</h2>
<table><tr><th>quantity</th><th>departs</th><th>largest</th><th>at</th><th>root mean square</th></tr>
{"".join(map(_row, shown))}</table>
</body></html>
"""


def _most_telling(found: Comparison) -> Sequence[Departure]:
    """Return what to plot: first what departs, one of each object; then what comes nearest to it."""
    first = first_of_each(found.departures)
    rest = [each for each in found.departures if each not in first]
    moving = [each for each in found.equal if each.largest > 0]
    return [*first, *rest, *moving, *(each for each in found.equal if each.largest == 0)][:MOST_PLOTS]


def _section(each: Departure, runs: tuple[Run, Run], names: Names) -> str:
    one, other = (run.series[each.quantity] for run in runs)
    count = one.values.shape[1]
    labels = _LABELS.get(each.quantity.name) or tuple(str(place) for place in range(count) if count > 1)
    title = f"{each.quantity} of {names.one} and {names.other}"
    unit = UNITS[each.quantity.name] if each.quantity.name != ORIENTATION else "quaternion"
    heading = f"{each.quantity}" + (f", {unit}" if unit else "")
    return f"<h3>{escape(heading)}</h3>" + plot(one, other, labels[:4], each.time, title)


def _row(each: Departure) -> str:
    departs = "within" if each.time is None else f"{each.time:.3f} s"
    cells = (departs, size_text(each, each.largest), f"{each.largest_time:.3f} s", size_text(each, each.rms))
    numbers = "".join(f'<td class="number">{escape(cell)}</td>' for cell in cells)
    return f"<tr><td>{escape(str(each.quantity))}</td>{numbers}</tr>\n"
