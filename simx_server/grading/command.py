"""``simx grade``: the flags, the output and the exit codes.

The client's program finds this module by the entry point ``simx.commands``.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_client.protocol.cli.parser import Parser
from simx_server.processes import log_format
from simx_server.sensors.opengl.mujoco_import import import_mujoco

MISSED = DIVERGED
"""Exit code for a program that has not met all checks."""

MOST_SEEDS = 100


def make_parser(program: str = "simx grade") -> argparse.ArgumentParser:
    """Return the parser.

    Args:
        program: the command as it was called, for help and messages.
    """
    parser = Parser(
        program,
        description="Run a program on a task, and give points for what the simulation did.",
        epilog=f"""\
examples:
  {program} task.toml submission.py                     the points
  {program} task.toml submission.py --seeds 5 --output results --film
  {program} task.toml --recording results/seed-1.simxlog
  {program} task.toml submission.py --gradescope /autograder/results/results.json
The program runs without network and files but its own (docs/grading.md).
exit codes: 0 all points, 1 nothing could be graded, 2 wrong usage, 3 less than all points
""",
    )
    parser.add_argument("task", metavar="TASK", type=Path, help="the task, a TOML file")
    parser.add_argument("program", metavar="PROGRAM", nargs="?", type=Path, help="the program, a Python file")
    parser.add_argument("--seeds", metavar="N", type=_seeds, help="number of attempts (the task's)")
    parser.add_argument(
        "--recording", metavar="FILE", type=Path, help="grade a recording of an attempt again instead"
    )
    parser.add_argument(
        "--output", metavar="DIR", type=Path, help="keep recordings, outputs and results.json there"
    )
    parser.add_argument("--film", action="store_true", help="also keep a film of each attempt there")
    parser.add_argument("--json", action="store_true", help="print the results as JSON")
    parser.add_argument(
        "--gradescope", metavar="FILE", type=Path, help="write the results.json of Gradescope"
    )
    parser.add_argument(
        "--github", action="store_true", help="write the result for GitHub Classroom to $GITHUB_OUTPUT"
    )
    return parser


def _seeds(text: str) -> int:
    try:
        if 1 <= int(text) <= MOST_SEEDS:
            return int(text)
    except ValueError:
        pass
    raise argparse.ArgumentTypeError(f"{text!r} is no number of seeds; valid: 1 to {MOST_SEEDS}")


def main(argv: Sequence[str] | None = None, program: str = "simx grade") -> int:
    """Grade a program. Returns the exit code."""
    parser = make_parser(program)
    options = parser.parse_args(argv)
    if (options.program is None) == (options.recording is None):
        parser.error("name a PROGRAM, or a recording by --recording")
    if options.recording is not None and options.seeds is not None:
        parser.error("--recording is one attempt: leave out --seeds")
    if options.film and options.output is None:
        parser.error("--film needs a folder for the films: --output DIR")
    if options.github and not os.environ.get("GITHUB_OUTPUT"):
        parser.error("--github is for a step of GitHub Actions, which sets GITHUB_OUTPUT")
    log_format.configure("warning", "text", several=False)
    import_mujoco()
    return _grade(options, program)


def _grade(options: argparse.Namespace, program: str) -> int:
    from . import reports
    from .grading import GradingFailed, Result, TaskError, grade, grade_recording, write_new
    from .task.task import read_task

    def tell(names: tuple[str, ...], result: Result) -> None:
        if not options.json:
            print("\n".join(reports.lines_of_attempt(names, result)), flush=True)

    try:
        task = read_task(options.task)
        told = partial(tell, tuple(each.name for each in task.checks))
        if options.recording is not None:
            found = grade_recording(task, options.recording, folder=options.output, films=options.film)
            told(found.results[0])
        else:
            found = grade(
                task,
                options.program,
                seeds=options.seeds,
                folder=options.output,
                films=options.film,
                told=told,
            )
        if options.output is not None:
            text = json.dumps(reports.as_record(found), indent=1)
            write_new(options.output / "results.json", text + "\n")
        if options.gradescope is not None:
            options.gradescope.parent.mkdir(parents=True, exist_ok=True)
            text = json.dumps(reports.as_gradescope(found), indent=1)
            options.gradescope.write_text(text + "\n", encoding="utf-8")
        if options.github:
            with open(os.environ["GITHUB_OUTPUT"], "a", encoding="utf-8") as stream:
                stream.write(reports.as_github(found))
    except (TaskError, GradingFailed, OSError) as problem:
        sys.stderr.write(f"{program}: {problem}\n")
        return FAILURE
    if options.json:
        print(json.dumps(reports.as_record(found)))
    else:
        print("\n".join(reports.summary(found)))
    return DONE if found.is_full else MISSED
