"""`make check` finds a vulnerable or badly licensed dependency, and says what it could not look up."""

from __future__ import annotations

import json
from importlib import metadata
from typing import Any

import audit
import pytest

SKIPPED = {"name": "numpy", "skip_reason": "Dependency not found on PyPI and could not be audited"}
CLEAN = {"name": "numpy", "version": "2.0", "vulns": []}
BAD = {"name": "zlib", "version": "1.0", "vulns": [{"id": "CVE-1", "fix_versions": ["1.1"]}]}


@pytest.mark.parametrize(
    ("said", "found", "known"),
    [
        ("", [], "NOT AUDITED: no database"),
        ("Traceback ...", [], "NOT AUDITED: no database"),
        ({"dependencies": [SKIPPED]}, [], "NOT AUDITED: the database that could be reached knows none"),
        ({"dependencies": [CLEAN]}, [], "1 packages looked up, 0 vulnerabilities"),
        ({"dependencies": [CLEAN, BAD]}, ["zlib 1.0 has CVE-1, mended in 1.1"], "2 packages looked up, 1"),
        (
            {"dependencies": [SKIPPED, BAD]},
            ["zlib 1.0 has CVE-1, mended in 1.1"],
            "NOT AUDITED, as unknown there: numpy",
        ),
    ],
)
def test_what_could_not_be_looked_up_is_said(said: Any, found: list[str], known: str) -> None:
    assert audit.judge_report(said if isinstance(said, str) else json.dumps(said))[0] == found
    assert known in audit.judge_report(said if isinstance(said, str) else json.dumps(said))[1]


class Package(metadata.Distribution):
    """A distribution with some lines of metadata."""

    def __init__(self, *lines: str) -> None:
        self._text = "\n".join(("Metadata-Version: 2.4", "Name: package", "Version: 1", *lines))

    def read_text(self, filename: str) -> str | None:
        return self._text if filename == "METADATA" else None

    def locate_file(self, path: Any) -> Any:
        raise NotImplementedError


@pytest.mark.parametrize(
    ("package", "is_wrong"),
    [
        (Package("License-Expression: BSD-3-Clause AND 0BSD AND MIT"), False),
        (Package("Classifier: License :: OSI Approved :: Apache Software License"), False),
        (Package("License-Expression: MIT AND GPL-3.0-only"), True),
        (Package("Classifier: License :: OSI Approved :: GNU Affero General Public License v3"), True),
        (Package(), True),
    ],
)
def test_licence_that_is_not_allowed_is_found(package: Any, is_wrong: bool) -> None:
    assert bool(audit.wrong_licences(iter([package]))) == is_wrong


def test_what_simx_needs_has_licences_that_are_allowed() -> None:
    names = {each.metadata["Name"].lower() for each in audit.needed(audit.required())}
    assert {"mujoco", "eclipse-zenoh", "msgpack", "numpy", "fissix", "ruckig"} <= names
    assert audit.wrong_licences(audit.needed(audit.required())) == []
