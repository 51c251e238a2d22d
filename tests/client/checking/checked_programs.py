"""simx-check on programs of several files that are given as texts."""

from __future__ import annotations

import contextlib
import io
import json
import textwrap
from pathlib import Path
from typing import Any

from simx_client.checking import command

START = "c = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)\nB = vrep.simx_opmode_blocking\n"


def write(folder: Path, files: dict[str, str]) -> None:
    """Texts by path."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(textwrap.dedent(text), encoding="utf-8")


def check(script: Path, *flags: str) -> tuple[int, dict[str, Any]]:
    """The exit code and the record."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        code = command.main([str(script), "--json", *flags])
    return code, json.loads(out.getvalue())


def page_of(script: Path, *flags: str) -> str:
    """The lines that people see."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        command.main([str(script), *flags])
    return out.getvalue()


def objects_of(record: dict[str, Any]) -> list[str]:
    return sorted(each["name"] for each in record["named"] if each["kind"] == "object")


def texts_of(record: dict[str, Any], level: str = "problem") -> list[str]:
    return [each["text"] for each in record["findings"] if each["level"] == level]


def files_of(record: dict[str, Any]) -> set[str]:
    return {Path(each).name for each in record["files"]}
