"""Recorded runs as files: NPZ, which `simx compare --save` writes, and CSV of poses and joints.

A column, or an array, is named ``OBJECT.QUANTITY``; in CSV a position has the columns x, y, z, an orientation qw, qx,
qy, qz. ``time`` has the seconds. An NPZ that was recorded has its times per quantity, and the calls as JSON.
"""

from __future__ import annotations

import csv
import json
import zipfile
from collections import defaultdict
from pathlib import Path
from typing import Any, cast

import numpy as np

from simx_server.errors import CommandError

from .quantities import ANSWER, UNITS, WIDTHS
from .trajectories import Call, Floats, Quantity, Run, Series

LARGEST = 1 << 30
"""Bytes of a file, and of what an NPZ unpacks to."""

TIME, CALLS, TIMES = "time", "calls", "time:"
_COLUMNS = {"x": ("position", 0), "y": ("position", 1), "z": ("position", 2)} | {
    name: ("orientation", place) for place, name in enumerate(("qw", "qx", "qy", "qz"))
}
_HOW = (
    "valid are 'time' and OBJECT.QUANTITY with a quantity of "
    + ", ".join(WIDTHS)
    + " (in CSV: x, y, z, qw, qx, qy, qz, joint, velocity, force)"
)


def read_run(path: Path) -> Run:
    """Read a recorded run.

    Raises:
        CommandError: the file cannot be used; the text says what is valid.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise CommandError(f"'{path}' has more than {LARGEST >> 20} MiB")
        run = _read_npz(path) if path.suffix.lower() == ".npz" else _read_csv(path)
    except OSError as error:
        raise CommandError(f"'{path}' cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, zipfile.BadZipFile, csv.Error, EOFError) as error:
        raise CommandError(f"'{path}' is no recorded run: {error}; {_HOW}") from None
    if not run.series:
        raise CommandError(f"'{path}' has no quantity of an object; {_HOW}")
    return run


def write_run(path: Path, run: Run) -> None:
    """Write a run as NPZ. Raises CommandError."""
    arrays: dict[str, Any] = {}
    for quantity, series in run.series.items():
        arrays[f"{quantity.owner}.{quantity.name}"] = series.values
        arrays[f"{TIMES}{quantity.owner}.{quantity.name}"] = series.times
    notes = {"steps": run.steps, "calls": [list(call) for call in run.calls]}
    arrays[CALLS] = np.array(json.dumps(notes))
    try:
        with path.open("wb") as file:  # the name as it is given, whatever its ending
            np.savez_compressed(file, **arrays)
    except OSError as error:
        raise CommandError(f"'{path}' cannot be written: {error.strerror}") from None


def _read_npz(path: Path) -> Run:
    with zipfile.ZipFile(path) as archive:
        if sum(each.file_size for each in archive.infolist()) > LARGEST:
            raise ValueError(f"it unpacks to more than {LARGEST >> 20} MiB")
    with np.load(path, allow_pickle=False) as content:
        arrays = {name: content[name] for name in content.files}
    notes: Any = json.loads(str(arrays.pop(CALLS))) if CALLS in arrays else {}
    if not isinstance(notes, dict):
        raise ValueError(f"its '{CALLS}' are not those of --save")
    common = arrays.pop(TIME, None)
    series: dict[Quantity, Series] = {}
    for name, array in arrays.items():
        if name.startswith(TIMES):
            continue
        times = arrays.get(TIMES + name, common)
        if times is None:
            raise ValueError(f"it has no times for '{name}'")
        series[_quantity(name)] = _series(name, times, array)
    calls = [Call(*each) for each in cast(Any, notes).get("calls", ())]
    return Run(series, calls, bool(cast(Any, notes).get("steps")))


def _quantity(name: str) -> Quantity:
    owner, dot, quantity = name.rpartition(".")
    if not dot or not owner or quantity not in UNITS:
        raise ValueError(f"'{name}' names no quantity")
    return Quantity(owner, quantity)


def _series(name: str, times: Any, values: Any) -> Series:
    times = np.asarray(times, dtype=float)
    values = np.asarray(values, dtype=float)
    if values.ndim == 1:
        values = values[:, None]
    width = WIDTHS.get(name.rpartition(".")[2])
    if times.ndim != 1 or values.ndim != 2 or len(times) != len(values):
        raise ValueError(f"'{name}' has the shape {values.shape}, and its times {times.shape}")
    if width is not None and values.shape[1] != width:
        raise ValueError(f"'{name}' has {values.shape[1]} columns, and needs {width}")
    keep = np.isfinite(values).all(axis=1) & np.isfinite(times)
    if np.any(np.diff(times[keep]) <= 0):
        raise ValueError(f"the times of '{name}' do not rise")
    return Series(times[keep], values[keep])


def _read_csv(path: Path) -> Run:
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = csv.reader(file)
        heads = [each.strip() for each in next(rows, list[str]())]
        if TIME not in heads:
            raise ValueError("its first line has no column 'time'")
        table = np.array(
            [[float(cell) if cell.strip() else np.nan for cell in row] for row in rows if row], dtype=float
        )
    if table.ndim != 2 or table.shape[1] != len(heads):
        raise ValueError("its lines have other numbers of columns than the first")
    found: dict[Quantity, dict[int, Floats]] = defaultdict(dict)
    for column, head in enumerate(heads):
        if head == TIME:
            continue
        owner, dot, last = head.rpartition(".")
        quantity, place = _COLUMNS.get(last, (last, 0))
        if not dot or not owner or quantity not in WIDTHS or (WIDTHS[quantity] > 1 and last not in _COLUMNS):
            raise ValueError(f"'{head}' names no quantity")
        found[Quantity(owner, quantity)][place] = table[:, column]
    times = table[:, heads.index(TIME)]
    series: dict[Quantity, Series] = {}
    for quantity, columns in found.items():
        if len(columns) != WIDTHS[quantity.name]:
            raise ValueError(f"the {quantity} has {len(columns)} of {WIDTHS[quantity.name]} columns")
        values = np.column_stack([columns[place] for place in range(len(columns))])
        series[quantity] = _series(f"{quantity.owner}.{quantity.name}", times, cast(Any, values))
    return Run(series)


def states(run: Run) -> dict[Quantity, Series]:
    """Return the quantities of objects, without answers."""
    return {quantity: each for quantity, each in run.series.items() if quantity.name != ANSWER}
