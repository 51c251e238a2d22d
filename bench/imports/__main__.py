"""Open all V-REP files below a folder, and print which functions their scripts need and the server lacks."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from simx_server.errors import CommandError
from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.opening import open_vrep
from simx_server.sim_api.listing.lacking import note_missing

SUFFIXES = (".ttt", ".ttm")

_SHOWN = 60
"""Missing functions in the listing."""


@dataclass
class Tally:
    """What was found in all files."""

    opened: int = 0
    failed: list[str] = field(default_factory=list[str])
    scripted: int = 0
    """Files with a script that runs."""
    complete: int = 0
    """Files with scripts of which none needs what the server lacks."""
    missing: Counter[str] = field(default_factory=Counter[str])
    """Number of files per missing function."""
    notes: Counter[str] = field(default_factory=Counter[str])
    """Number of files per sentence of their reports."""
    slowest: tuple[float, str] = (0.0, "")
    """Seconds, and the file."""

    def add(self, path: Path) -> None:
        """Open a file and count its report."""
        begin = time.perf_counter()
        try:
            spec, report, _ = open_vrep(path.read_bytes(), path.name)
            build(spec, None)
        except CommandError as problem:
            self.failed.append(str(problem))
            return
        self.slowest = max(self.slowest, (time.perf_counter() - begin, path.name))
        self.opened += 1
        note_missing(report)
        self.notes.update([*report.approximated, *report.left_out])
        if report.needs:
            self.scripted += 1
            self.complete += not report.missing_functions
            self.missing.update(report.missing_functions.keys())

    def as_text(self) -> str:
        """Return the figures for people."""
        share = self.complete / self.scripted if self.scripted else 1.0
        lines = [
            f"{self.opened} files opened, {len(self.failed)} refused; the slowest took {self.slowest[0]:.1f} s "
            f"('{self.slowest[1]}')",
            f"{self.scripted} files have scripts; {self.complete} ({share:.0%}) meet no missing function",
        ]
        for title, counts in (("missing, by files", self.missing), ("notes, by files", self.notes)):
            lines += ["", f"{title}:", *(f"{count:6} {name}" for name, count in counts.most_common(_SHOWN))]
        if self.failed:
            lines += ["", "refused:", *(f"  {problem}" for problem in self.failed)]
        return "\n".join(lines)


def tally(folder: Path) -> Tally:
    """Return what was found in all V-REP files below a folder."""
    found = Tally()
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in SUFFIXES and path.is_file():
            found.add(path)
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the figures of a folder; return the exit code."""
    parser = argparse.ArgumentParser("python -m bench.imports", description=__doc__)
    parser.add_argument(
        "folder", type=Path, metavar="FOLDER", help="all .ttt and .ttm files below it are opened"
    )
    print(tally(parser.parse_args(arguments).folder).as_text())
    return 0


if __name__ == "__main__":
    sys.exit(main())
