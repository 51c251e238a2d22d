"""The dependencies: versions that fit, licences that are allowed, no known vulnerability.

The first two need no network. The third asks a database of vulnerabilities by pip-audit; where that cannot be reached
this says so in a line of its own and does not fail, for then nothing is known. Exit code 1: something is wrong.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

PROJECT = "simx-vrep"
ALLOWED = (
    "apache",
    "mit",
    "bsd",
    "isc",
    "zlib",
    "cc0",
    "psf",
    "python software foundation",
    "mpl",
    "eclipse",
)
"""Beginnings of the licences that what simx needs may have: of those, nothing but a notice is asked of its users."""

TIMEOUT = 300.0
"""Seconds for all questions to the database; each has five."""


def required() -> list[str]:
    """What pyproject.toml says that simx needs at run time."""
    text = (Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)["project"]["dependencies"]


def needed(requirements: Iterable[str], seen: set[str] | None = None) -> Iterator[metadata.Distribution]:
    """The distributions that are required, and what these need at run time, as they are installed here."""
    seen = set() if seen is None else seen
    for requirement in requirements:
        found = re.match(r"[A-Za-z0-9._-]+", requirement)
        if found is None or "extra ==" in requirement or found[0].lower() in seen:
            continue
        seen.add(found[0].lower())
        try:
            distribution = metadata.distribution(found[0])
        except metadata.PackageNotFoundError:  # for another system; pip check tells those that are missing
            continue
        yield distribution
        yield from needed(distribution.requires or (), seen)


def licences(distribution: metadata.Distribution) -> list[str]:
    """Alternatives or parts of a licence, as the package tells them; nothing when it does not."""
    about = distribution.metadata.json
    told = [line.split(" :: ")[-1] for line in about.get("classifier", ()) if line.startswith("License ::")]
    said = about.get("license_expression") or about.get("license")
    parts = told or re.split(r"[()]|\bAND\b|\bOR\b", str(said or "").partition("\n")[0])
    return [part.strip() for part in parts if part.strip()]


def wrong_licences(distributions: Iterator[metadata.Distribution]) -> list[str]:
    """A sentence for each that has a licence which is not allowed, or does not say which."""
    wrong: list[str] = []
    for each in distributions:
        found = licences(each)
        if not found or not all(name.lower().removeprefix("0").startswith(ALLOWED) for name in found):
            what = " and ".join(found) or "unknown"
            wrong.append(f"{each.metadata['Name']}: licence {what}; allowed: {', '.join(ALLOWED)}")
    return wrong


def judge_report(text: str) -> tuple[list[str], str]:
    """The vulnerabilities in what pip-audit said as JSON, and how much of it is known.

    pip-audit ends well when a package was not found where it asked, as with a mirror that knows no vulnerabilities; so
    what was skipped is counted.
    """
    try:
        entries: list[dict[str, Any]] = json.loads(text)["dependencies"]
    except (ValueError, KeyError, TypeError):
        return [], "NOT AUDITED: no database of vulnerabilities could be reached from here"
    asked = [each for each in entries if "vulns" in each]
    if not asked:
        return [], "NOT AUDITED: the database that could be reached knows none of the packages"
    found = [
        f"{each['name']} {each['version']} has {vulnerability['id']}, mended in "
        f"{', '.join(vulnerability['fix_versions']) or 'no version yet'}"
        for each in asked
        for vulnerability in each["vulns"]
    ]
    missing = [each["name"] for each in entries if "vulns" not in each and each["name"] != PROJECT]
    known = f"{len(asked)} packages looked up, {len(found)} vulnerabilities"
    return found, known + (f"; NOT AUDITED, as unknown there: {', '.join(missing)}" if missing else "")


def ask_database() -> str:
    """What pip-audit says as JSON; nothing when it cannot."""
    command = [sys.executable, "-m", "pip_audit", "--local", "--skip-editable", "--format", "json"]
    options = ["--progress-spinner", "off", "--timeout", "5"]
    try:
        return subprocess.run([*command, *options], capture_output=True, text=True, timeout=TIMEOUT).stdout
    except subprocess.TimeoutExpired:
        return ""


def main() -> int:
    """Print what is wrong and what is not known."""
    fits = subprocess.run([sys.executable, "-m", "pip", "check"], capture_output=True, text=True)
    problems = fits.stdout.splitlines() if fits.returncode else []
    problems += wrong_licences(needed(required()))
    found, known = judge_report(ask_database())
    print("\n".join([*problems, *found, known]))
    return 1 if problems or found else 0


if __name__ == "__main__":
    sys.exit(main())
