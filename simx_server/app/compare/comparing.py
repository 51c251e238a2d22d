"""Run a program at the original and here, or take recorded runs, and print what departs."""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from simx_client.protocol.cli.exit_codes import DIVERGED, DONE, FAILURE
from simx_client.protocol.cli.installing import extra_line
from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError, StartError
from simx_server.recording.replayed import Divergence
from simx_server.settings.settings import Settings

from .departures import TOLERANCES, Comparison, Tolerance, compare
from .files import read_run, states, write_run
from .page import page
from .quantities import UNITS
from .replayed import replayed, silenced
from .running import ZMQ, record_here, run_against, run_here, target_of
from .text import Names, lines, record
from .trajectories import Run


def print_comparison(options: argparse.Namespace, program: str) -> int:
    """Compare, and print the result. Returns the exit code.

    Args:
        options: the values of the flags.
        program: the command as it was called, for messages.
    """
    silenced()
    try:
        tolerances = tolerances_of(options.tolerance)
        names, one, other = _runs(options)
    except (CommandError, StartError, Divergence) as error:
        sys.stderr.write(f"{program}: {error}\n")
        return FAILURE
    steps = (one.steps and other.steps) or bool(options.recorded)
    found = compare(one, other, tolerances, steps=steps)
    if options.page is not None:
        title = f"{Path(options.program).name}: {names.one} and {names.other}"
        try:
            options.page.write_text(page(title, found, (one, other), names, steps=steps), encoding="utf-8")
        except OSError as error:
            sys.stderr.write(f"{program}: '{options.page}' cannot be written: {error.strerror}\n")
            return FAILURE
    print(json.dumps(record(found)) if options.json else "\n".join(lines(found, names, steps=steps)))
    return exit_code(found)


def exit_code(found: Comparison) -> int:
    """Return the exit code of a result."""
    return DONE if found.is_equal else DIVERGED if found.departures or found.ends_early else FAILURE


def tolerances_of(texts: Sequence[str]) -> Mapping[str, Tolerance]:
    """Return the tolerances with those that a user has chosen. Raises CommandError."""
    chosen = dict(TOLERANCES)
    for text in texts:
        name, _, value = text.partition("=")
        if name not in TOLERANCES:
            raise CommandError(
                f"there is no tolerance '{name}'{did_you_mean(name, TOLERANCES)}; valid are {', '.join(TOLERANCES)}"
            )
        try:
            number = float(value)
        except ValueError:
            number = -1.0
        if not 0 <= number < float("inf"):
            raise CommandError(
                f"the tolerance {name} is a number from 0 in {UNITS[name] or 'its unit'}, not '{value}'"
            )
        chosen[name] = Tolerance(number)
    return chosen


def _runs(options: argparse.Namespace) -> tuple[Names, Run, Run]:
    """Return the names of the two runs, and the runs. Raises CommandError."""
    program = [options.program, *options.arguments]
    if options.recorded is not None:
        return _with_recorded(options, program)
    target = target_of(options.original)
    if target.protocol == ZMQ:
        _require_zmq()
    one = run_against(target, program, options.timeout)
    if options.save is not None:
        write_run(options.save, one.run)
    other = run_here(options.scene, target.protocol, program, options.timeout, options.server_arg)
    names = Names(f"original ({target.host}:{target.port})", f"here ({options.scene})")
    if one.exit_code != other.exit_code:
        sys.stderr.write(
            f"the program ended with code {one.exit_code} at the original, and with {other.exit_code} here\n"
        )
    return names, one.run, other.run


def _with_recorded(options: argparse.Namespace, program: Sequence[str]) -> tuple[Names, Run, Run]:
    path: Path = options.recorded
    chosen = Settings(allow_code=options.allow_code)
    one = replayed(path, chosen=chosen) if path.suffix == ".simxlog" else read_run(path)
    with tempfile.TemporaryDirectory(prefix="simx-compare-") as folder:
        recording = Path(folder) / "here.simxlog"
        record_here(options.scene, program, options.timeout, recording, options.server_arg)
        other = replayed(recording, states(one).keys(), chosen=chosen)
    return Names(f"recorded ({path.name})", f"here ({options.scene})"), replace(one, calls=[]), other


def _require_zmq() -> None:
    """Raise CommandError where the packages for the ZeroMQ port are missing."""
    try:
        import cbor2  # noqa: F401  # pyright: ignore[reportUnusedImport]
        import zmq  # noqa: F401  # pyright: ignore[reportUnusedImport]
    except ImportError as error:
        raise CommandError(
            f"a ZeroMQ port needs the package {error.name}; install it: {extra_line('compare')}"
        ) from None
