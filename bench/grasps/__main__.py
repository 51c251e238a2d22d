"""``python -m bench.grasps --pyrep PATH --rlbench PATH``: print the table of docs/grasps.md."""

from __future__ import annotations

import argparse
import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

from .arms import ARMS, swing
from .grippers import GRIPPERS
from .things import THINGS
from .trial import Held, trial

HEAD = ("gripper", f"held, of {len(THINGS)}", "slip", "turn", "creep in 30 s", "aside")


def row(name: str, found: Mapping[str, Held]) -> str:
    """Return a row of the table: the greatest numbers of what was not lost."""
    held = [one for one in found.values() if not one.lost]
    lost = ", ".join(f"`{thing}`" for thing, one in found.items() if one.lost)
    cells = [name, f"{len(held)}, not {lost}" if lost else str(len(held))]
    if held:
        cells += [
            f"{max(one.slip for one in held):.2f} mm",
            f"{max(one.turn for one in held):.1f}°",
            f"{max(one.creep for one in held):.3f} mm",
            f"{max(one.aside for one in held):.1f} mm",
        ]
    return f"| {' | '.join(cells)} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m bench.grasps", description=__doc__)
    parser.add_argument("--pyrep", type=Path, required=True, help="a checkout of PyRep")
    parser.add_argument("--rlbench", type=Path, required=True, help="a checkout of RLBench")
    parser.add_argument("--stop", action="store_true", help="stop the motors with the fingers, as PyRep does")
    chosen = parser.parse_args(arguments)
    logging.basicConfig(level=logging.ERROR)
    models = chosen.pyrep / "robot_ttms" / "end_effectors"
    things = chosen.rlbench / "rlbench" / "task_ttms"
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name, gripper in GRIPPERS.items():
        found = {
            thing.name: trial(gripper, thing, models, things, keeps_closing=not chosen.stop)
            for thing in THINGS
        }
        print(row(name, found), flush=True)
    for name, arm in ARMS.items():
        print(row(f"arm: {name}", {"box": swing(arm, chosen.rlbench / "rlbench" / "robot_ttms")}), flush=True)


if __name__ == "__main__":
    main()
