"""Tell the web viewer about scripts with their errors, graphs, readings of sensors as lines, and files."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy as np

from simx_server.errors import CommandError
from simx_server.files.library import list_models, list_scenes
from simx_server.parts.user_interface.contents.plot import Curve, Plot
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.interpreter import ScriptError

from .messages import Files, Ray, ScriptView, Sensing

if TYPE_CHECKING:
    from simx_server.parts.graphs.streams import Graph
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_MOST_SCRIPTS = 200
_MOST_LETTERS = 600
_MOST_SENSORS = 300
_LINE = re.compile(r":(\d+):")
"""In an error's text, ``name:line: the reason``."""


_INVISIBLE, _UNLISTED, _POINTS = 1, 2, 4
"""Options of a stream."""


def plot_of(graph: Graph) -> Plot:
    """Return the streams of a graph over time."""
    plot = Plot(labels=["s", ""], has_legend=True)
    for stream in graph.streams.values():
        if not stream.options & _INVISIBLE:
            samples = stream.data()
            red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in stream.color)
            plot.curves[stream.name] = Curve(
                color=(red, green, blue),
                style="scatter" if stream.options & _POINTS else "line",
                is_in_legend=not stream.options & _UNLISTED,
                x=[time for time, _ in samples],
                y=[value for _, value in samples],
            )
    return plot


def script_views(world: World) -> list[ScriptView]:
    """Return the scripts of the scene, those that an error has stopped first."""
    scripts = sorted(world.scripts.all(), key=lambda script: not script.problem)
    return [_script_view(world, script) for script in scripts[:_MOST_SCRIPTS]]


def _script_view(world: World, script: Script) -> ScriptView:
    line, code = _failed_line(world, script) if script.problem else (-1, "")
    return {
        "handle": script.handle,
        "name": world.scripts.describe(script),
        "is_running": script.interpreter is not None,
        "is_enabled": script.is_enabled,
        "problem": script.problem[:_MOST_LETTERS],
        "line": line,
        "code": code,
    }


def _failed_line(world: World, script: Script) -> tuple[int, str]:
    """Return the number and the text of the line in which a script has failed; -1 if it is not known."""
    found = _LINE.search(script.problem)
    if found is None:
        return -1, ""
    number = int(found[1])
    try:
        lines = script.source(world.simulation).decode("utf-8", "replace").splitlines()
    except (ScriptError, CommandError):
        return number, ""
    return number, lines[number - 1].strip()[:_MOST_LETTERS] if 0 < number <= len(lines) else ""


def sensing(world: World) -> Sensing:
    """Return the readings of proximity sensors and force sensors, in the world's frame.

    A sensor with random rays is left out unless a client or script has read it: each reading of it is another one.
    """
    sim = world.simulation
    sim.refresh()
    rays: list[Ray] = []
    for handle in sim.scene.of_kind(ObjectKind.PROXIMITY_SENSOR)[:_MOST_SENSORS]:
        item = sim.scene.objects[handle]
        origin, turn = sim.data.site_xpos[item.id], sim.data.site_xmat[item.id].reshape(3, 3)
        known, found = world.proximity.peek(handle)
        if not known:
            continue
        local = (
            np.array([0.0, 0.0, world.proximity.reach(handle)]) if found is None else np.array(found.point)
        )
        end = origin + turn @ local
        rays.append({"start": origin.tolist(), "end": end.tolist(), "detects": found is not None})
    forces: list[list[float]] = []
    for handle in sim.scene.of_kind(ObjectKind.FORCE_SENSOR)[:_MOST_SENSORS]:
        item, reading = sim.scene.objects[handle], world.force.newest(handle)
        if reading is not None:
            turn = sim.data.site_xmat[item.id].reshape(3, 3)
            forces.append([*sim.data.site_xpos[item.id].tolist(), *(turn @ np.array(reading.force)).tolist()])
    return {"rays": rays, "forces": forces}


def shipped_files() -> Files:
    """Return the names of shipped scenes and models."""
    return {"scenes": list_scenes(), "models": list_models()}
