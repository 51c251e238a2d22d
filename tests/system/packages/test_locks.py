"""The lock files: what make setup, the container and a class install, file by file."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[3]
spec = importlib.util.spec_from_file_location("lock", ROOT / "packages" / "lock.py")
assert spec is not None
assert spec.loader is not None
lock = importlib.util.module_from_spec(spec)
spec.loader.exec_module(lock)

PINNED = re.compile(
    r"^([\w.-]+)(?:\[[\w,-]+\])?==(\S+)(?: ; [^\\]+)? \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)",
    re.M,
)


def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize("name", lock.LOCKS)
def test_a_lock_fits_pyproject(name: str) -> None:
    text = lock.path_of(name).read_text(encoding="utf-8")
    assert text.startswith(lock.sign(lock.requirements(name)) + "\n"), "run `make lock`"
    pinned: dict[str, set[str]] = {}
    for package, version, _ in PINNED.findall(text):
        pinned.setdefault(package, set()).add(version)
    for text in lock.requirements(name):
        if not text.startswith("python "):
            requirement = Requirement(text)
            versions = pinned[requirement.name.lower()]
            assert all(requirement.specifier.contains(Version(each)) for each in versions), text


@pytest.mark.parametrize("name", lock.LOCKS)
def test_a_lock_has_hashes_and_nothing_but_packages(name: str) -> None:
    text = lock.path_of(name).read_text(encoding="utf-8")
    packages = re.sub(r"\A(#[^\n]*\n){2}", "", text)
    assert PINNED.sub("", packages) == ""
    assert "://" not in text


@pytest.mark.parametrize("name", lock.LOCKS)
def test_a_lock_names_the_extras_that_packages_need(name: str) -> None:
    text = lock.path_of(name).read_text(encoding="utf-8")
    pinned: dict[str, set[str]] = {}
    for package, extras in re.findall(r"^([\w.-]+)(?:\[([\w,-]+)\])?==", text, re.M):
        pinned.setdefault(package, set()).update(extras.split(",") if extras else ())
    for package, extras in pinned.items():
        try:
            needed = importlib.metadata.requires(package) or []
        except importlib.metadata.PackageNotFoundError:  # for another system or Python
            continue
        for requirement in map(Requirement, needed):
            environments = [{"extra": extra} for extra in ("", *extras)]
            if requirement.marker is None or any(map(requirement.marker.evaluate, environments)):
                # pip would look for the newest release, and refuse it for its missing hash
                assert requirement.extras <= pinned.get(canonicalize_name(requirement.name), set()), package


def test_another_requirement_needs_another_lock() -> None:
    now = lock.requirements("setup", project())
    for change in ("dependencies", "dev"):
        changed = project()
        extras = changed["optional-dependencies"]
        (changed["dependencies"] if change == "dependencies" else extras["dev"]).append("another>=1")
        assert lock.sign(lock.requirements("setup", changed)) != lock.sign(now)
    assert lock.sign(lock.requirements("setup", project())) == lock.sign(now)


def test_what_installs_takes_the_locks() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "--require-hashes -r $(LOCKS)/setup.lock" in makefile
    image = (ROOT / "deploy" / "Containerfile").read_text(encoding="utf-8")
    assert re.search(r"^FROM \S+@sha256:[0-9a-f]{64}$", image, re.MULTILINE)
    assert "--require-hashes -r /tmp/simx/packages/locks/server.lock" in image
