"""``python -m bench.counts``: print what an operation makes Python do, beside the committed counts."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from .cases import Counts, counted

COMMITTED = Path(__file__).with_name("counts.json")
GROWTH = 1.25
"""Times the committed count that an operation may reach."""

FEW = 3.0
"""Counts may exceed the committed ones by this much in any case: a server looks about now and then."""


def committed() -> dict[str, Counts]:
    """Return the counts that the others are held against."""
    return json.loads(COMMITTED.read_text())


def grown(before: Mapping[str, Counts], now: Mapping[str, Counts]) -> list[str]:
    """Return a sentence for each count that is more than a quarter above the one before, or has none before."""
    return [
        *(f"{operation}: counts.json lacks it" for operation in now if operation not in before),
        *(
            f"{operation}: {what} grew from {before[operation][what]:g} to {number:g}"
            for operation, counts in now.items()
            for what, number in counts.items()
            if (most := before.get(operation, {}).get(what)) is not None and number > most * GROWTH + FEW
        ),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Count, and print a table; return 1 if something has grown."""
    parser = argparse.ArgumentParser("python -m bench.counts", description=__doc__)
    parser.add_argument("--write", action="store_true", help="have the committed counts be those of now")
    parsed = parser.parse_args(arguments)
    before = committed() if COMMITTED.exists() else {}
    now = {
        operation: {what: round(number, 1) for what, number in counts.items()}
        for operation, counts in counted().items()
    }
    for operation, counts in now.items():
        print(operation)
        for what, number in counts.items():
            was = before.get(operation, {}).get(what)
            print(f"  {what:28}{number:10g}" + (f"   (committed: {was:g})" if was is not None else ""))
    if parsed.write:
        COMMITTED.write_text(json.dumps(now, indent=2) + "\n")
        return 0
    for sentence in (problems := grown(before, now)):
        print(sentence, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
