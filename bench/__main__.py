"""``python -m bench``: run the measurements, write the report."""

from __future__ import annotations

import argparse
import importlib
import logging
import os
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

from simx_client.protocol.cli.parser import Parser
from simx_client.protocol.nearest import did_you_mean

from .calls.client import CallFailed
from .measuring import paces
from .measuring.machine import Watch, description
from .measuring.measure import FULL, QUICK
from .measuring.processes import NotReady
from .measuring.report import DETAILS, PLOTS, Findings, bars_of, compose, details
from .measuring.scheduling import DISTURBANCE, go_real_time, scheduling

logger = logging.getLogger("bench")

MEASUREMENTS = {
    "blocking": "bench.calls.blocking",
    "one_host": "bench.calls.one_host",
    "streaming": "bench.calls.streaming",
    "clients": "bench.load.clients",
    "step": "bench.world.step",
    "stepping": "bench.calls.stepping",
    "embedded": "bench.calls.embedded",
    "worlds": "bench.calls.worlds",
    "picture": "bench.images.picture",
    "sizes": "bench.images.sizes",
    "servers": "bench.load.servers",
    "batch": "bench.calls.batch",
    "original": "bench.calls.original",
    "scenes": "bench.world.scenes",
    "sensors": "bench.world.sensors",
    "rays": "bench.world.rays",
    "script_calls": "bench.world.script_calls",
    "view": "bench.load.view",
    "startup": "bench.load.startup",
    "scale": "bench.load.scale",
    "growth": "bench.world.growth",
    "classroom": "bench.load.classroom",
    "edits": "bench.world.edits",
    "bursts": "bench.world.bursts",
    "vrep": "bench.world.vrep_files",
    "zmq": "bench.zmq.calls",
    "ros2": "bench.ros2.steps",
    "learning": "bench.learning.growth",
    "environments": "bench.learning.environments",
}
"""By name the module whose function ``measure`` makes it, in the order of the report."""

REPORT = Path(__file__).with_name("REPORT.md")

PACES = REPORT.with_name("paces.json")
"""Figures of runs at other paces."""


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(
        "python -m bench",
        description="Measure what a call, a pass and an image cost here, each beside its baseline.",
        epilog="A full run also writes bench/REPORT.md, bench/DETAILS.md and bench/plots/; a shorter one only prints, "
        "unless --report is given.",
    )
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"some of {', '.join(MEASUREMENTS)}; all by default"
    )
    parser.add_argument("--quick", action="store_true", help="fewer and shorter rounds: rough figures")
    parser.add_argument(
        "--real-time",
        action="store_true",
        help="run with SCHED_RR, ahead of other programs, where the system permits it; others get little time",
    )
    parser.add_argument(
        "--pace",
        choices=paces.PACES,
        default="idle",
        help="keep all cores busy meanwhile, or use one only; adds a column to the next report",
    )
    parser.add_argument("--report", type=Path, metavar="FILE", help="write the report there")
    parsed = parser.parse_args(arguments)
    for name in parsed.names:
        if name not in MEASUREMENTS:
            meant = did_you_mean(name, MEASUREMENTS) or ";"
            parser.error(f"there is no measurement {name!r}{meant} there are {', '.join(MEASUREMENTS)}")
    return parsed


def _leave(number: int, frame: FrameType | None) -> None:
    """SIGTERM as an exception, so that the processes that were started are ended."""
    raise SystemExit(128 + number)


REPEATS_S = 90.0
"""Seconds that repetitions of disturbed turns may take in a full run."""


def run(
    names: Sequence[str], *, quick: bool = False, pace: str = paces.IDLE
) -> tuple[list[str], list[Findings]]:
    """Run measurements by name; return the conditions of the run and what was found."""
    effort, watch = (QUICK if quick else FULL), Watch()
    if pace == paces.IDLE:
        DISTURBANCE.begin(REPEATS_S * effort.factor)
    findings: list[Findings] = []
    took: dict[str, float] = {}
    for place, name in enumerate(names, 1):
        logger.info("[%d/%d] %s", place, len(names), name)
        # Imported when it is needed: some load MuJoCo, and a blocking call is timed in a process as lean as a script.
        measure = importlib.import_module(MEASUREMENTS[name]).measure
        began = time.monotonic()
        with paces.kept(pace):
            findings.append(measure(effort))
        took[name] = time.monotonic() - began
        watch.look()
    parts = ", ".join(f"{name} {seconds:.0f}" for name, seconds in took.items())
    run_time = f"{'a quick' if quick else 'a full'} run of {sum(took.values()):.0f} s ({parts})"
    conditions = [*description(), *scheduling(), *watch.lines(), *DISTURBANCE.lines(), run_time]
    return conditions, findings


def _draw(folder: Path, findings: Sequence[Findings]) -> None:
    # Afterwards: OpenCV would make the process larger than a script's.
    from .measuring.drawing_bars import draw_bars
    from .measuring.plot import draw

    for found in findings:
        for plot in found.plots:
            draw(folder, plot)
    if (bars := bars_of(findings)) is not None:
        draw_bars(folder, bars)


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit code: 0, 1 when a measurement could not be made, 130 when interrupted."""
    chosen = _arguments(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s", stream=sys.stderr)
    for noisy in ("simx_client", "simx_server"):
        logging.getLogger(noisy).setLevel(logging.WARNING)
    signal.signal(signal.SIGTERM, _leave)
    # Compiling the sources at each start would be measured instead of the start.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    if chosen.real_time and not go_real_time():
        logger.error("SCHED_RR is not permitted; run as root, or without --real-time")
        return 1
    pace = paces.PACES[chosen.pace]
    is_idle, is_whole = pace == paces.IDLE, not chosen.names and not chosen.quick
    try:
        conditions, findings = run(chosen.names or list(MEASUREMENTS), quick=chosen.quick, pace=pace)
    except (CallFailed, NotReady) as error:
        logger.error("%s", error)
        return 1
    except KeyboardInterrupt:
        return 130
    others: list[paces.AtPace] = []
    if not is_idle and not chosen.names:
        paces.store(PACES, pace, conditions[-1], findings)
    elif is_whole:
        others = paces.load(PACES)
        conditions += [f"{each.pace}: {each.condition}" for each in others]
    report = compose(findings, conditions=conditions, others={each.pace: each.found for each in others})
    more = details(findings, conditions=conditions)
    sys.stdout.write(report if is_whole else f"{report}\n{more}")
    if target := chosen.report or (REPORT if is_whole and is_idle else None):
        target.write_text(report, encoding="utf-8")
        target.with_name(DETAILS).write_text(more, encoding="utf-8")
        _draw(target.parent / PLOTS, findings)
        logger.info("written to %s and %s", target, DETAILS)
    return 0


if __name__ == "__main__":
    sys.exit(main())
