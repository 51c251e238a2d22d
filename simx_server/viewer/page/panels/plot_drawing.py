"""A plot of a window as SVG."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

_WIDTH, _HEIGHT = 320.0, 200.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 8.0, 8.0, 34.0
"""Borders in units of the drawing."""

_GREY = "rgba(128,128,128,0.6)"
_LONGEST_NAME = 40

Point = tuple[float, float]


def as_svg(plot: dict[str, Any]) -> str:
    """Return a drawing of what `Plot.view` returns."""
    (low, high), (bottom, top) = plot["x"], plot["y"]
    across, up = high - low, top - bottom

    def place(point: Sequence[float]) -> Point:
        x = (point[0] - low) / across if across else 0.5
        y = (point[1] - bottom) / up if up else 0.5
        # Far points would be drawn outside of the frame, which hides them, but not with any number.
        x, y = (min(max(each, -9.0), 10.0) for each in (x, y))
        return _LEFT + x * (_WIDTH - _LEFT - _RIGHT), _HEIGHT - _BOTTOM - y * (_HEIGHT - _TOP - _BOTTOM)

    curves = "".join(
        _curve(curve, [place(each) for each in curve["points"] if all(map(math.isfinite, each))])
        for curve in plot["curves"]
    )
    frame = f'x="{_LEFT}" y="{_TOP}" width="{_WIDTH - _LEFT - _RIGHT}" height="{_HEIGHT - _TOP - _BOTTOM}"'
    return (
        f'<div style="padding:0 0.75em 0.5em"><svg viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" '
        'style="width:100%;font-size:9px" fill="currentColor">'
        f'<rect {frame} fill="none" stroke="{_GREY}"/>'
        f'<svg {frame} viewBox="{_LEFT} {_TOP} {_WIDTH - _LEFT - _RIGHT} {_HEIGHT - _TOP - _BOTTOM}">{curves}</svg>'
        f"{_axes(plot)}{_legend(plot) if plot['legend'] else ''}</svg></div>"
    )


def _curve(curve: dict[str, Any], points: list[Point]) -> str:
    red, green, blue = (int(part) for part in curve["color"])
    color, style = f"rgb({red},{green},{blue})", str(curve["style"])
    size = float(curve["line"])
    found = ""
    if style == "impulse":
        base = _HEIGHT - _BOTTOM
        line = " ".join(f"M{x:.2f} {base:.2f}L{x:.2f} {y:.2f}" for x, y in points)
    elif style == "scatter":
        line = ""
    else:
        line = "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in _stepped(points, style)) if points else ""
    if line:
        dashes = ' stroke-dasharray="4 3"' if curve["dashed"] else ""
        found += f'<path d="{line}" fill="none" stroke="{color}" stroke-width="{size:g}"{dashes}/>'
    if style in ("scatter", "line_and_scatter"):
        radius = float(curve["scatter"]) / 2
        found += "".join(
            f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius:g}" fill="{color}"/>' for x, y in points
        )
    return found


def _stepped(points: list[Point], style: str) -> list[Point]:
    """Return the corners of a line, which has steps where the style says so."""
    if not style.startswith("step") or len(points) < 2:
        return points
    found = points[:1]
    for (x0, y0), (x1, y1) in pairwise(points):
        at = {"step_left": x1, "step_right": x0}.get(style, (x0 + x1) / 2)
        found += [(at, y0), (at, y1), (x1, y1)]
    return found


def _axes(plot: dict[str, Any]) -> str:
    (low, high), (bottom, top) = plot["x"], plot["y"]
    middle, base = _LEFT + (_WIDTH - _LEFT - _RIGHT) / 2, _HEIGHT - _BOTTOM
    along, aside = (html.escape(str(label)[:_LONGEST_NAME]) for label in plot["labels"])
    height = _TOP + (base - _TOP) / 2
    return (
        f'<text x="{_LEFT}" y="{base + 11}">{low:.4g}</text>'
        f'<text x="{_WIDTH - _RIGHT}" y="{base + 11}" text-anchor="end">{high:.4g}</text>'
        f'<text x="{_LEFT - 3}" y="{base}" text-anchor="end">{bottom:.4g}</text>'
        f'<text x="{_LEFT - 3}" y="{_TOP + 8}" text-anchor="end">{top:.4g}</text>'
        f'<text x="{middle}" y="{_HEIGHT - 6}" text-anchor="middle">{along}</text>'
        f'<text transform="translate(10 {height}) rotate(-90)" text-anchor="middle">{aside}</text>'
    )


def _legend(plot: dict[str, Any]) -> str:
    listed = [curve for curve in plot["curves"] if curve["listed"]]
    lines: list[str] = []
    for index, curve in enumerate(listed):
        red, green, blue = (int(part) for part in curve["color"])
        y = _TOP + 11 * (index + 1)
        name = html.escape(str(curve["name"])[:_LONGEST_NAME])
        lines.append(
            f'<rect x="{_LEFT + 6}" y="{y - 6}" width="10" height="3" fill="rgb({red},{green},{blue})"/>'
            f'<text x="{_LEFT + 20}" y="{y}">{name}</text>'
        )
    return "".join(lines)
