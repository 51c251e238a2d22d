"""The files that a wheel gets, its commands, systems that are not POSIX."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import sysconfig
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from processes import ROOT

import simx_client
import simx_server
from simx_server.app.doctor import machine
from simx_server.app.doctor.findings import WARNING
from simx_server.errors import CommandError
from simx_server.motion_profiles import line
from simx_server.recording.log_file import MAGIC, LogWriter

pytestmark = pytest.mark.slow


def test_the_commands_of_the_package_are_there() -> None:
    commands = {
        entry.name: entry
        for entry in metadata.distribution("simx-vrep").entry_points.select(group="console_scripts")
    }
    assert set(commands) == {"simx-server", "simx-run", "simx-check", "simx"}
    assert all(callable(entry.load()) for entry in commands.values())


def test_make_knows_the_file_that_links_an_environment_to_this_folder() -> None:
    """Without it `make` installs the project again, as after pip has installed `'.[EXTRA]'`."""
    origin = json.loads(metadata.distribution("simx-vrep").read_text("direct_url.json") or "{}")
    if not origin.get("dir_info", {}).get("editable"):
        pytest.skip("the project is not installed in editable form")
    (name,) = re.findall(r"site-packages/(\S+\.pth)", (ROOT / "Makefile").read_text(encoding="utf-8"))
    assert Path(sysconfig.get_path("purelib"), name).exists()


def test_a_wheel_has_the_scenes_the_types_and_every_other_file_of_the_packages(tmp_path: Path) -> None:
    """Not built: hatchling is asked which files it would take."""
    builder = pytest.importorskip("hatchling.builders.wheel").WheelBuilder(str(ROOT))
    taken = {Path(each.distribution_path).as_posix() for each in builder.recurse_included_files()}
    kept = subprocess.run(
        ["git", "ls-files", "simx_server", "simx_client", "scenes"], cwd=ROOT, capture_output=True, text=True
    )
    if kept.returncode:
        pytest.skip("no repository of git, so nobody knows which files belong to it")
    expected = {re.sub(r"^scenes/", "simx_server/shipped_scenes/", each) for each in kept.stdout.splitlines()}
    assert {"simx_client/py.typed", "simx_server/shipped_scenes/models/rg2.lua"} <= expected
    assert sorted(each for each in expected - taken if (ROOT / each).exists()) == []
    assert not [each for each in taken if each.startswith(("tests", "bench", "docs"))]


def test_a_source_archive_has_every_page_of_the_root_and_what_it_links_to() -> None:
    """Not built: hatchling is asked which files it would take."""
    builder = pytest.importorskip("hatchling.builders.sdist").SdistBuilder(str(ROOT))
    taken = {Path(each.relative_path).as_posix() for each in builder.recurse_included_files()}
    pages = {path.name for path in ROOT.glob("*.md")} | {"CITATION.cff", "LICENSE", "Makefile"}
    assert {"README.md", "CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md"} <= pages
    # Readme and licence, which the project's table names, are added by hatchling itself.
    assert pages - {"README.md", "LICENSE"} <= taken
    linked = {
        link.partition("#")[0]
        for page in sorted(pages)
        for link in re.findall(r"\]\(([^):]+)\)", (ROOT / page).read_text(encoding="utf-8"))
    }
    assert "docs/internals/architecture.md" in linked
    missing = [link for link in linked if link and link not in taken | pages and not (ROOT / link).is_dir()]
    assert missing == []


def test_a_citation_says_what_the_project_says() -> None:
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    fields = dict(re.findall(r"^([a-z-]+): *(.*)$", text, re.MULTILINE))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert fields["cff-version"] == "1.2.0"
    assert fields["version"] == simx_server.__version__
    assert fields["license"] == project["license"]
    names = re.findall(r'^  - name: "(.*)"$', text, re.MULTILINE)
    assert names == [author["name"] for author in project["authors"]]
    assert {"message", "title", "authors"} <= fields.keys()


def test_the_changelog_has_this_version_with_its_date() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = re.findall(r"^## (.*)$", text, re.MULTILINE)
    released = re.search(r"^date-released: (.*)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)
    assert released is not None
    assert headings[:2] == ["Unreleased", f"{simx_server.__version__} - {released[1]}"]


WITH_A_CLIENT_ONLY = """
import sys
import sysconfig
for name in ("mujoco", "numpy", "cv2", "lupa", "fissix", "ruckig"):
    sys.modules[name] = None
import simx_client, simx_client.client.client, simx_client.launch.run, simx_server.app.doctor.page
from simx_server.app.cli import main
sys.exit(main([]))
"""


def test_where_only_a_client_is_installed_it_works_and_a_server_tells_what_is_missing() -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", WITH_A_CLIENT_ONLY], cwd=ROOT, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr.count("\n")) == (1, 1), done.stderr
    assert "the package mujoco is not installed; " in done.stderr


def test_a_recording_needs_no_flag_that_windows_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr("os.O_CLOEXEC")
    LogWriter(tmp_path / "a.simxlog").close()
    assert (tmp_path / "a.simxlog").read_bytes() == MAGIC


def test_what_a_pipe_of_windows_cannot_show_is_a_question_mark_there(tmp_path: Path) -> None:
    script = tmp_path / "old.py"
    script.write_text(
        "import vrep\nvrep.simxReadProximitySensor(0, 3, vrep.simx_opmode_blocking)\n", encoding="utf-8"
    )
    done = subprocess.run(
        [sys.executable, "-m", "simx_client", "check", script, "--differences"],
        cwd=ROOT,
        env={"PYTHONIOENCODING": "ascii", "PATH": ""},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, "?1" in done.stdout) == (0, True), done.stderr


def test_without_ruckig_only_motion_profiles_are_missing_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", None)
    with pytest.raises(CommandError, match="motion profiles need the package ruckig, which is not installed"):
        line(1, 1, 1)


def test_a_package_without_a_wheel_for_this_system_is_no_problem_but_is_told() -> None:
    finding, _ = machine.check_packages(["numpy", "surely-not-there>=1; platform_machine == 'x86_64'"])
    assert finding.level == WARNING
    assert "surely-not-there" in finding.text


@pytest.mark.parametrize("package", [simx_client, simx_server])
def test_the_packages_say_that_they_are_typed(package: object) -> None:
    assert (Path(str(package.__file__)).parent / "py.typed").is_file()  # type: ignore[attr-defined]
