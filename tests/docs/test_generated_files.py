"""`make generate` writes every generated file; other tests hold their contents."""

from __future__ import annotations

import re
import subprocess

from processes import ROOT

PAGE = re.compile(r"^Made by `(?P<command>[^`]+) > (?P<path>docs/[\w-]+\.md)`", re.MULTILINE)
STUBS = re.compile(r'^"""[^`]*Generated (?:from the table )?by ``(?P<command>[^`]+)``')


def test_make_generate_has_the_command_of_every_generated_file() -> None:
    shown = subprocess.run(["make", "-n", "generate"], cwd=ROOT, capture_output=True, text=True)
    assert shown.returncode == 0, shown.stderr
    recipe = shown.stdout.replace(".venv/bin/", "")
    pages = [
        found for page in (ROOT / "docs").rglob("*.md") if (found := PAGE.search(page.read_text("utf-8")))
    ]
    stubs = [
        found
        for folder in ("simx_client", "packages/types")
        for stub in (ROOT / folder).rglob("*.pyi")
        if (found := STUBS.match(stub.read_text("utf-8")))
    ]
    assert (len(pages), len(stubs)) == (4, 7)
    for page in pages:
        assert f"{page['command']} > {page['path']}.new && mv {page['path']}.new {page['path']} " in recipe
    for stub in stubs:
        assert f"{stub['command']}\n" in recipe
