"""Fit values of a scene, and print and write them."""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_server.app.compare.departures import compare
from simx_server.app.compare.files import read_run, states
from simx_server.app.compare.quantities import JOINT, ORIENTATION, POSITION, VELOCITY
from simx_server.app.compare.replayed import replayed, silenced
from simx_server.app.compare.running import record_here
from simx_server.app.compare.text import Names, lines
from simx_server.app.compare.trajectories import Run
from simx_server.app.scene_sources import sources_of
from simx_server.errors import CommandError, StartError
from simx_server.files.library import find_scene
from simx_server.recording.replayed import Divergence
from simx_server.scene.formats.exporting.folder import write_folder
from simx_server.scene.formats.saving import save_mjcf
from simx_server.scene.formats.specs import read_scene
from simx_server.scene.formats.whole_files import is_whole_file
from simx_server.settings.settings import Settings

from .fitting import Outcome, Problem, fit, sysid
from .parameters import Free, free_of

_SIMXLOG = ".simxlog"

MET = (POSITION, ORIENTATION, JOINT, VELOCITY)
"""Quantities that are met without others. Forces jump where motors are at their limits, which makes a fit rough."""


def print_fit(options: argparse.Namespace, program: str) -> int:
    """Fit, and print the values. Returns the exit code.

    Args:
        options: the values of the flags.
        program: the command as it was called, for messages.
    """
    silenced()
    logging.getLogger("absl").setLevel(logging.ERROR)
    try:
        sysid()
        with tempfile.TemporaryDirectory(prefix="simx-fit-") as folder:
            free, target, outcome, first = _fit(options, Path(folder))
            if options.save is not None:
                save(options.scene, options.save, free, [each.value for each in outcome.values])
    except (CommandError, StartError, Divergence) as error:
        sys.stderr.write(f"{program}: {error}\n")
        return FAILURE
    if options.json:
        print(json.dumps(_record(outcome)))
    else:
        print("\n".join(_lines(outcome, target, first)))
    return DONE


def _fit(options: argparse.Namespace, folder: Path) -> tuple[list[Free], Run, Outcome, Run]:
    spec = read_scene(find_scene(options.scene), sources_of(Settings())).spec
    free = [free_of(text, spec) for text in options.free]
    if len({str(each) for each in free}) < len(free):
        raise CommandError("--free names a value twice")
    recorded: Path = options.recorded
    chosen = Settings(allow_code=options.allow_code)
    target = replayed(recorded, chosen=chosen) if recorded.suffix == _SIMXLOG else read_run(recorded)
    target = Run(
        {
            quantity: series
            for quantity, series in states(target).items()
            if quantity.name in (options.quantity or MET)
        }
    )
    recording = Path(options.program)
    if recording.suffix != _SIMXLOG:
        recording = folder / "here.simxlog"
        record_here(options.scene, [options.program, *options.arguments], options.timeout, recording)

    def report(line: str) -> None:
        if options.verbose:
            print(line, file=sys.stderr)

    problem = Problem(recording, target, free, chosen=chosen, report=report)
    return free, problem.moving, fit(problem, free, most_iterations=options.iterations), problem.first


def save(scene: str, target: Path, free: Sequence[Free], values: Sequence[float]) -> None:
    """Write the scene with the values: MJCF's own as attributes, V-REP's as annotations. Raises CommandError."""

    def change(spec: Any) -> None:
        for each, value in zip(free, values, strict=True):
            each.put(spec, float(f"{value:.6g}"))

    file, sources = find_scene(scene), replace(sources_of(Settings()), change=change)
    if is_whole_file(file):
        write_folder(file, target, sources)
    else:
        save_mjcf(file, target, sources)


def _lines(outcome: Outcome, target: Run, first: Run) -> Iterator[str]:
    yield f"fitted {len(outcome.values)} values by {outcome.replays} replays"
    yield f"difference, in shares of the ranges: {outcome.before:.3g} before, {outcome.after:.3g} after"
    for each in outcome.values:
        told = (
            "the run does not tell it"
            if math.isinf(each.factor)
            else f"within a factor of {each.factor:.4g} (95 %)"
        )
        bound = ", at its bound" if each.is_at_bound else ""
        yield f"  {each.free}: {each.free.start:.5g} -> {each.value:.5g}, {told}{bound}"
        yield f"    {each.free.written(each.value)}"
    for title, run in (("before", first), ("after", outcome.run)):
        yield f"{title}:"
        yield from (f"  {line}" for line in lines(compare(target, run), Names("recorded", "here")))


def _record(outcome: Outcome) -> dict[str, Any]:
    return {
        "values": {
            str(each.free): {
                "start": each.free.start,
                "value": each.value,
                "factor": each.factor if math.isfinite(each.factor) else None,
                "is_at_bound": each.is_at_bound,
                "written": each.free.written(each.value),
            }
            for each in outcome.values
        },
        "before": outcome.before,
        "after": outcome.after,
        "replays": outcome.replays,
    }
