"""The packages that texts name can be installed, from a clone and from a wheel, and are named in one place."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from simx_client.protocol.cli import installing

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS: dict[str, list[str]] = PROJECT["optional-dependencies"]
IN_CLONE_OR_WHEEL = pytest.mark.parametrize("where", ["clone", "wheel"])


@pytest.fixture(autouse=True)
def place(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A wheel has no pyproject.toml, only the metadata that a build made of it."""
    if "where" in request.fixturenames and request.getfixturevalue("where") == "wheel":
        monkeypatch.setattr(installing, "_PROJECT", tmp_path / "pyproject.toml")


def packages_of(line: str) -> set[Requirement]:
    """The requirements that a line installs, as the shell hands them to pip."""
    _, _, rest = line.partition(" install ")
    return {Requirement(word) for word in shlex.split(rest)}


@IN_CLONE_OR_WHEEL
@pytest.mark.parametrize("extra", sorted(EXTRAS))
def test_an_extras_line_names_the_packages_behind_it(extra: str, where: str) -> None:
    line = installing.extra_line(extra)
    wanted = {Requirement(text) for text in EXTRAS[extra] if installing.is_for_this_python(text)}
    assert packages_of(line) == wanted
    assert installing.DISTRIBUTION not in line  # it is on no index


@IN_CLONE_OR_WHEEL
def test_all_that_a_server_needs_is_what_the_project_declares(
    where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def absent(name: str) -> str:
        raise metadata.PackageNotFoundError(name)

    wanted = {Requirement(text) for text in PROJECT["dependencies"]}
    assert packages_of(installing.missing_line()) == wanted
    version = metadata.version
    monkeypatch.setattr(metadata, "version", lambda name: absent(name) if name == "mujoco" else version(name))
    assert packages_of(installing.missing_line()) == {each for each in wanted if each.name == "mujoco"}


@IN_CLONE_OR_WHEEL
def test_one_package_comes_in_the_version_that_the_project_takes(where: str) -> None:
    (lupa,) = (text for text in PROJECT["dependencies"] if text.startswith("lupa"))
    assert packages_of(installing.package_line("lupa")) == {Requirement(lupa)}
    assert installing.package_line("somebody-elses").endswith(" install somebody-elses")


def test_where_nothing_is_known_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(installing, "_PROJECT", tmp_path / "pyproject.toml")
    monkeypatch.setattr(installing, "DISTRIBUTION", "surely-not-there")
    assert installing.declared() == {}
    assert installing.extra_line("viewer").endswith("'surely-not-there[viewer]'")


@pytest.mark.parametrize(
    ("requirement", "extra", "whole"),
    [
        ("one<2,>=1", None, "one<2,>=1"),
        ("one; extra == 'x'", "x", "one"),
        ('one>=1 ; extra == "x"', "x", "one>=1"),
        ("one>=1; (python_version < '3.13') and extra == 'x'", "x", "one>=1; (python_version < '3.13')"),
        ("one>=1; python_version < '3.13'", None, "one>=1; python_version < '3.13'"),
    ],
)
def test_requirements_are_sorted_by_the_extra_that_asks(
    requirement: str, extra: str | None, whole: str
) -> None:
    assert installing.by_extra([requirement]) == {extra: [whole]}


def test_the_line_is_for_the_python_that_runs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys, "executable", str(tmp_path / "my python" / "python"))
    other = lambda name: "/elsewhere/pip" if name == "pip" else None  # noqa: E731
    monkeypatch.setattr(shutil, "which", other)
    assert shlex.split(installing.line(["a>=1"])) == [sys.executable, "-m", "pip", "install", "a>=1"]
    monkeypatch.setattr(shutil, "which", lambda name: str(Path(sys.executable).with_name("pip")))
    assert installing.line(["a>=1"]) == "pip install 'a>=1'"


def test_an_environment_of_uv_has_no_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installing.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(shutil, "which", lambda name: f"/tools/{name}")
    assert installing.line(["a"]).startswith("uv pip install --python ")


def test_pip_takes_such_a_line() -> None:
    """For packages that are here already, so that nothing is asked of an index."""
    line = installing.extra_line("log") + " --dry-run --no-index --no-deps --disable-pip-version-check"
    if installing._is_installed("mcap") and installing._is_installed("foxglove-schemas-protobuf"):
        done = subprocess.run(line, shell=True, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, done.stderr
    else:
        pytest.skip("needs the extra log")


BY_HAND = re.compile(r"\bpip3? install\b")


def test_pyrep_and_rlbench_are_installed_from_their_repositories_without_the_simulator() -> None:
    for package, repository in (("pyrep", "PyRep"), ("rlbench", "RLBench")):
        root, _, line = installing.pyrep_line(package).partition(" ")
        assert root == "COPPELIASIM_ROOT=$(simx-run"
        assert line.endswith(f" install git+https://github.com/stepjam/{repository}.git")


def test_no_hint_is_written_by_hand() -> None:
    """Else it names this project, which no index has, or versions that the project has left behind."""
    files = [
        path
        for folder in ("simx_client", "simx_server", "examples", "bench", "tests")
        for path in (ROOT / folder).rglob("*.py")
        if path.name not in ("installing.py", "test_installing.py") and "old_programs" not in path.parts
    ]
    assert len(files) > 100
    found = {path.name: BY_HAND.findall(path.read_text(encoding="utf-8")) for path in files}
    assert {name for name, hints in found.items() if hints} == set()


def test_pages_install_this_project_by_a_path() -> None:
    """A name alone would be looked up on an index."""
    by_name = re.compile(rf"pip install [^`\n]*?(?<![/\w.]){installing.DISTRIBUTION}\b")
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]
    found = [f"{page.name}: {hint}" for page in pages for hint in by_name.findall(page.read_text("utf-8"))]
    assert found == []


def test_requirements_for_other_versions_of_python_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    requirements = ["a; python_version < '3.14'", 'b ; (python_version >= "3.14")', "c; os_name == 'nt'", "d"]
    for version, expected in {(3, 13, 1): "acd", (3, 14, 0): "bcd"}.items():
        monkeypatch.setattr(installing.sys, "version_info", version)
        assert "".join(each[0] for each in requirements if installing.is_for_this_python(each)) == expected
    assert "pygame-ce" in installing.extra_line("demo")
