"""docs/llms.txt is the list of pages as docs/index.md has it."""

from __future__ import annotations

import subprocess
import sys

from processes import ROOT


def test_the_list_for_agents_is_made_from_the_contents() -> None:
    made = subprocess.run(
        [sys.executable, ROOT / "docs" / "llms.py"], capture_output=True, text=True, check=True
    )
    assert made.stdout == (ROOT / "docs" / "llms.txt").read_text(encoding="utf-8")
    pages = {path.name for path in (ROOT / "docs").glob("*.md")} - {"index.md"}
    assert all(f"]({name}): " in made.stdout for name in pages)
