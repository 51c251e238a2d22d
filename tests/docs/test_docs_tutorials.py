"""The programs of the tutorials run as their pages say, and print what is shown there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import cv2
import numpy as np
import pytest
from launching import forked
from processes import ROOT

pytestmark = [pytest.mark.slow, pytest.mark.gl]

DOCS = ROOT / "docs"
TUTORIALS = sorted(path.stem for path in (DOCS / "tutorials").glob("*.md"))
BLOCK = re.compile(r"^```(\w+) ([^\n]+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def page(name: str) -> str:
    return (DOCS / "tutorials" / f"{name}.md").read_text(encoding="utf-8")


def run(name: str, folder: Path) -> tuple[str, str]:
    """Write the page's program and run its command line; return what is printed, and what the page shows."""
    found = {language: (title, text) for language, title, text in BLOCK.findall(page(name))}
    file, program = found["python"]
    (folder / file).write_text(program, encoding="utf-8")
    line, shown = found["text"]
    command, *arguments = shlex.split(line)
    start = ("-m", "simx_client", "run") if command == "simx-run" else ()
    finished = forked(folder, *start, *arguments)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout, shown


@pytest.mark.parametrize(
    "name", [name for name in TUTORIALS if name not in ("training", "your-scene", "class")]
)
def test_a_tutorial_prints_what_its_page_shows(name: str, tmp_path: Path) -> None:
    printed, shown = run(name, tmp_path)
    assert printed == shown
    if name == "camera":
        made, kept = (
            cv2.imread(str(path)) for path in (tmp_path / "ball.png", DOCS / "pictures/tutorial-ball.jpg")
        )
        assert made is not None
        assert kept is not None
        assert np.mean(cv2.absdiff(made, kept)) < 4, "the picture of the page is another"


def test_the_tutorial_about_training_learns(tmp_path: Path) -> None:
    printed, shown = run("training", tmp_path)
    pattern = re.compile(r"^generation (\d): mean (\d+), best (\d+)$", re.MULTILINE)
    rows, shown_rows = pattern.findall(printed), pattern.findall(shown)
    assert [row[0] for row in rows] == [row[0] for row in shown_rows]
    assert int(rows[-1][1]) > 3 * int(rows[0][1])


def test_each_tutorial_has_a_picture_and_leads_to_the_next() -> None:
    for name in TUTORIALS:
        assert len(re.findall(r"^!\[[^]]+\]\(\.\./pictures/", page(name), re.MULTILINE)) == 1, name
    order = ["first-script"]
    while found := re.search(r"^Next: \[[^]]+\]\((\S+)\.md\)", page(order[-1]), re.MULTILINE):
        order.append(found[1])
    assert sorted(order) == TUTORIALS
