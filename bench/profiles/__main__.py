"""``python -m bench.profiles``: print where the time of operations goes; ``--write`` makes ``bench/PROFILES.md``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from bench.measuring import machine
from bench.measuring.report import number

from .cases import Profile, profiles

PAGE = Path(__file__).resolve().parents[1] / "PROFILES.md"
LEAST = 0.03
"""Share of the wall clock's time from which a row is shown."""

DEPTH = 3
"""Folders are told apart to this depth."""

MAIN = 0.5
"""Share of a folder's time from which its function is named."""

HEAD = """# Where the time goes

`python -m bench.profiles --write` makes this page: operations whose aims in [REPORT.md](REPORT.md) are not all reached.
The main thread of each process is looked at every millisecond of processor time. A call into C (MuJoCo, Lua, the
system) counts for the function of Python that made it, or for the next one that it calls. A function is named if it
takes at least half of its folder's time.
"No main thread computes": they wait, for other threads or for the system to wake them.

What the figures say:

- Embedded loops: beside physics, which is in C, no folder takes a tenth of the time of 50 ms. The rest is many small
  parts, and at 1 ms these take longer than physics.
- Stop and start: half of the time makes the state of the gripper's Lua script, with the functions that it may call.
- Edits: MuJoCo copies and compiles the whole scene for each burst of edits. In a large scene that is most of the time.
- Cart-poles: most of the time is physics, in threads of C.
- Between two processes on one host, the server's `send` mostly returns after the client's next message: they take turns
  on one core, and all parts add up. A client that polled for a trigger's answer instead of sleeping made the loop twice
  as long in two of three runs, and equally long in the third.
- Over Zenoh, its threads take as long as the work of client and server, and each hand-over wakes another thread.
- A burst of targets over Zenoh is two messages: the targets, and the question whether they were executed. The second
  one takes most of what is beyond a read.
- A scanner's script: a third of the time passes between Lua and Python; the rest is spread over the layers of a call.
- Image lists: the tutorial's own loop takes most of the time. Python 3.11 reads an item of a subclass of list, which an
  image is, slower than an item of a plain list.
- Many worlds and servers: physics takes most of the time; each process meets it with cold caches.
- ROS 2: the node's messages take as long as the physics of a small arm.
"""


def page(found: Iterable[Profile]) -> str:
    """Return the page."""
    conditions = [f"- {line}\n" for line in machine.description()]
    return "".join([HEAD, "\n", *conditions, "\n", "\n".join(map(_section, found))])


def _section(profile: Profile) -> str:
    scale, unit = (1e3, "ms") if profile.seconds > 0.01 else (1e6, "us")

    def row(name: str, seconds: float) -> str:
        return f"| {name} | {number(seconds * scale)} | {seconds / profile.seconds:.0%} |"

    lines = [
        f"## {profile.name}\n",
        f"| what | {unit} | share |",
        "|---|---:|---:|",
        row("in all", profile.seconds),
    ]
    least = LEAST * profile.seconds
    for process, taken in profile.processes.items():
        whose = f"{process}: " if process else ""
        shown = {name: seconds for name, seconds in _by_folder(taken.by_function).items() if seconds >= least}
        lines += [row(whose + name, seconds) for name, seconds in shown.items()]
        lines.append(row(f"{whose}all else in the main thread", taken.main - sum(shown.values())))
        if taken.others >= least:
            lines.append(row(f"{whose}other threads", taken.others))
    waiting = profile.seconds - sum(taken.main for taken in profile.processes.values())
    if waiting >= least:
        lines.append(row("no main thread computes", waiting))
    return "\n".join(lines) + "\n"


def _by_folder(by_function: Mapping[str, float]) -> dict[str, float]:
    """Return the times by folder, the largest first, with the name of a function that takes most of it."""
    folders: dict[str, dict[str, float]] = {}
    for name, seconds in by_function.items():
        folder, function = _parted(name)
        functions = folders.setdefault(folder, {})
        functions[function] = functions.get(function, 0.0) + seconds
    found: dict[str, float] = {}
    for folder, functions in sorted(folders.items(), key=lambda each: -sum(each[1].values())):
        total, name = sum(functions.values()), max(functions, key=functions.__getitem__)
        found[f"{folder}: `{name}`" if functions[name] >= MAIN * total else folder] = total
    return found


def _parted(name: str) -> tuple[str, str]:
    """Return a function's folder and its name within that."""
    if name.startswith("<frozen importlib"):
        return "Python's import of modules", name
    path, _, function = name.rpartition("/")
    if not path:
        return "libraries of Python", function
    parts = path.split("/")
    return "/".join(parts[:DEPTH]), "/".join([*parts[DEPTH:], function])


def main(arguments: Sequence[str] | None = None) -> int:
    """Look into all operations, and print or write the page."""
    parser = argparse.ArgumentParser("python -m bench.profiles", description=__doc__)
    parser.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    parsed = parser.parse_args(arguments)
    written = page(profiles())
    if parsed.write:
        PAGE.write_text(written, encoding="utf-8")
    print(written)
    return 0


if __name__ == "__main__":
    sys.exit(main())
