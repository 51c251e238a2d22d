"""The markers system and gl: which tests get them."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import kinds_of_tests
import pytest
from processes import ROOT


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("import subprocess", True),
        ("def test_it():\n    from multiprocessing import Process", True),
        ("from processes import ROOT, server", True),
        ("from processes import ROOT, wait_until", False),
        ("from launching import python", True),  # which imports subprocess
        ("import helper", True),
        ("from conftest import scene", False),
        ("import simx_server.app.doctor", False),
    ],
)
def test_a_file_that_imports_what_starts_processes_is_of_the_system(
    text: str, expected: bool, tmp_path: Path
) -> None:
    (tmp_path / "helper.py").write_text("from subprocess import run\n", encoding="utf-8")
    (tmp_path / "test_file.py").write_text(text + "\n", encoding="utf-8")
    assert kinds_of_tests._starts_processes(tmp_path / "test_file.py") is expected


def test_a_test_that_casts_rays_needs_no_opengl() -> None:
    """Of the tests that render with both back ends."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "tests/server/sensors/test_rendering.py",
        "--collect-only",
        "-q",
        "-m",
        "gl",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert ("[opengl" in done.stdout, "[raycast" in done.stdout) == (True, False)
