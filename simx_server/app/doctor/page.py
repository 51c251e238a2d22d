"""Run all checks in order and print them, for people or for programs."""

from __future__ import annotations

import json
import sys
import textwrap
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict

from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.terminal import Paint
from simx_server.settings.rules import port_of
from simx_server.settings.settings import Settings

from . import graphics, machine, network
from .findings import OK, PROBLEM, WARNING, Finding

COLOURS = {OK: "green", WARNING: "yellow", PROBLEM: "red"}
WIDTH = 100
_EDGE = 9 + 15

Check = Callable[[], Iterable[Finding]]


def checks(settings: Settings) -> list[Check]:
    """Return the checks in order."""
    return [
        lambda: [machine.check_python()],
        machine.check_packages,
        lambda: [machine.check_cores(), machine.check_memory()],
        machine.check_compiled_forms,
        lambda: [machine.check_workspace(settings.workspace)],
        lambda: network.check_ports([*settings.ports, *map(port_of, settings.legacy_ports)]),
        lambda: [network.check_zenoh()],
        graphics.check_backends,
        lambda: graphics.check_scene(settings.scene),
    ]


def print_findings(settings: Settings, *, as_json: bool) -> int:
    """Run all checks with these settings, and print the findings. Returns the exit code: 1 with any problem."""
    found: list[Finding] = []
    paint = Paint(sys.stdout)
    for finding in run(checks(settings)):
        found.append(finding)
        if not as_json:
            sys.stdout.writelines(f"{line}\n" for line in as_lines(finding, paint))
            sys.stdout.flush()
    works = all(each.level != PROBLEM for each in found)
    if as_json:
        record = {"works": works, "findings": [asdict(each) for each in found]}
        sys.stdout.write(json.dumps(record, indent=1) + "\n")
    else:
        sys.stdout.write(summary(found, paint) + "\n")
    return DONE if works else FAILURE


def run(wanted: Iterable[Check]) -> Iterator[Finding]:
    """Yield the findings in order. Two checks run at a time: most of them wait for a child process."""
    with ThreadPoolExecutor(2, thread_name_prefix="simx-doctor") as pool:
        for findings in pool.map(_all_of, list(wanted)):
            yield from findings


def _all_of(check: Check) -> list[Finding]:
    return list(check())


def as_lines(finding: Finding, paint: Paint) -> list[str]:
    """Return the lines for people: level, topic, finding, and below it the next step."""
    head = f"{paint(format(finding.level, '8'), COLOURS[finding.level])} {finding.topic:14} "
    lines = textwrap.wrap(finding.text, WIDTH - _EDGE, break_long_words=False, break_on_hyphens=False) or [""]
    if finding.advice:
        advice = f"-> {finding.advice}"
        lines += textwrap.wrap(advice, WIDTH - _EDGE, break_long_words=False, break_on_hyphens=False)
    return [head + lines[0], *(" " * _EDGE + line for line in lines[1:])]


def summary(found: Iterable[Finding], paint: Paint) -> str:
    """Return the closing line."""
    levels = [each.level for each in found]
    problems, warnings = levels.count(PROBLEM), levels.count(WARNING)
    counts = [
        f"{count} {word}{'s' * (count > 1)}"
        for count, word in ((problems, PROBLEM), (warnings, WARNING))
        if count
    ]
    if problems:
        return paint(f"the server will not work well here: {', '.join(counts)}", "red")
    if warnings:
        return paint(f"the server works here: {', '.join(counts)}", "yellow")
    return paint("the server works here", "green")
