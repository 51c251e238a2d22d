"""A release: one number and one address in all places; workflows that name what there is. Nothing is published."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from processes import ROOT

WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
PLACES = (
    "CHANGELOG.md",
    "CITATION.cff",
    "pyproject.toml",
    "simx_client/protocol/version.py",
    ".github/CODEOWNERS",
)
ADDRESS = "https://github.com/Robots/simx"

pytestmark = pytest.mark.skipif(not WORKFLOWS, reason="a source archive has no workflows")


def load(name: str) -> ModuleType:
    """Load a program of packages/."""
    spec = importlib.util.spec_from_file_location(f"{name}_of_packages", ROOT / "packages" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


release = load("release")


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A repository with the places that have the version or the address."""
    for place in PLACES:
        (tmp_path / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / place, tmp_path / place)
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "a test")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "test@example.org")
    tree = release.Tree(tmp_path)
    tree.change(Path("CHANGELOG.md"), r"^## Unreleased\n()", "\n- News.\n")
    for words in (["init", "--quiet"], ["add", "."], ["commit", "--quiet", "--message", "all"]):
        tree.git(*words)
    return tree


def run(tree: Any, *words: str) -> int:
    return release.main(list(words), tree)


def test_one_number_makes_version_changelog_citation_and_tag(
    tree: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(tree, "address", ADDRESS) == 0
    tree.git("commit", "--quiet", "--all", "--message", "address")
    assert run(tree, "new", "7.8.9", "--date", "2030-01-02") == 0
    assert "git push --atomic origin HEAD v7.8.9" in capsys.readouterr().out
    assert tree.git("status", "--porcelain") == ""
    assert tree.git("tag", "--points-at", "HEAD") == "v7.8.9"
    assert tree.version == "7.8.9"
    assert re.findall(r"^## (.*)$", tree.read(Path("CHANGELOG.md")), re.MULTILINE)[:2] == [
        "Unreleased",
        "7.8.9 - 2030-01-02",
    ]
    assert "\nversion: 7.8.9\ndate-released: 2030-01-02\n" in tree.read(Path("CITATION.cff"))
    assert run(tree, "check", "v7.8.9") == 0
    assert (run(tree, "minor"), run(tree, "notes")) == (0, 0)
    said = capsys.readouterr().out
    assert said.startswith("7.8\n- News.\n")
    assert run(tree, "new", "7.8.10") == 1
    assert "nothing under Unreleased" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("version", "reason"), [("1.2", "not a version"), ("0.0.1", "not newer"), ("9.0.0", "not committed")]
)
def test_what_is_no_release_is_refused_and_changes_nothing(
    tree: Any, version: str, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tree.root / "new file").touch()
    before = {place: tree.read(Path(place)) for place in PLACES}
    assert run(tree, "new", version) == 1
    assert reason in capsys.readouterr().err
    assert before == {place: tree.read(Path(place)) for place in PLACES}
    assert tree.git("tag", "--list") == ""


def test_a_candidate_comes_before_its_version() -> None:
    versions = ["1.10.0", "1.0.0", "1.0.1", "1.0.0rc2", "0.9.1", "1.0.0rc1"]
    assert sorted(versions, key=release._key) == ["0.9.1", "1.0.0rc1", "1.0.0rc2", "1.0.0", "1.0.1", "1.10.0"]


def test_a_tag_is_checked_against_every_place(tree: Any) -> None:
    assert any("no address yet" in each for each in release.check(tree, f"v{tree.version}"))
    release.set_address(tree, ADDRESS)
    assert release.check(tree, f"v{tree.version}") == []
    assert len(release.check(tree, "v99.0.0")) == 1
    tree.change(Path("CITATION.cff"), r"^version: (.+)$", "99.0.0")
    assert release.check(tree, f"v{tree.version}") == ["CITATION.cff has another version"]


def test_an_address_reaches_every_place_and_can_change(tree: Any) -> None:
    for address in (ADDRESS, "https://github.com/Other-Team/sim.x"):
        release.set_address(tree, address)
        assert release.check_address(tree) == []
        urls = tomllib.loads(tree.read(Path("pyproject.toml")))["project"]["urls"]
        assert urls["Issues"] == f"{address}/issues"
    assert urls["Documentation"] == "https://other-team.github.io/sim.x/"
    assert ADDRESS not in "".join(tree.read(Path(place)) for place in PLACES)
    with pytest.raises(release.Wrong, match="is not an address such as"):
        release.set_address(tree, "http://example.org")


def test_the_tree_has_one_address_or_none() -> None:
    """The places agree, also before a release."""
    tree = release.Tree(ROOT)
    if tree.address:
        assert release.check_address(tree) == []
    else:
        found = [place for place in PLACES if "github.com/" in tree.read(Path(place))]
        assert found == []


# --- workflows ------------------------------------------------------------------------------------


def workflow(path: Path) -> dict[str, Any]:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    return yaml.safe_load(path.read_text(encoding="utf-8"))


def steps() -> list[dict[str, Any]]:
    return [
        step for path in WORKFLOWS for job in workflow(path)["jobs"].values() for step in job.get("steps", ())
    ]


def test_workflows_fit_their_schemas() -> None:
    """`make check-release` asks more checkers; this one is installed by .ci/run."""
    pytest.importorskip("check_jsonschema", reason="check-jsonschema is not installed")
    forms = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("[!c]*.yml"))
    assert len(forms) == 3
    for schema, files in {"github-workflows": WORKFLOWS, "github-issue-forms": forms}.items():
        command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}", *files]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout


def test_every_action_is_pinned_by_its_commit_and_says_its_version() -> None:
    used = [
        line.partition("uses: ")[2]
        for path in WORKFLOWS
        for line in path.read_text(encoding="utf-8").splitlines()
        if "uses: " in line
    ]
    assert len(used) > 20
    assert [each for each in used if not re.match(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", each)] == []
    assert len({each.split()[0].partition("@")[0] for each in used}) == len(
        {each.split()[0] for each in used}
    )


def test_workflows_run_commands_and_files_that_there_are() -> None:
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    texts = "\n".join(step["run"] for step in steps() if "run" in step)
    made = re.findall(r"\bmake ([a-z-]+)", texts)
    assert {"dist-archives", "check-dist", "check-release", "sbom", "site-version"} == set(made)
    assert set(made) <= set(targets)
    for path in re.findall(r"\b(?:packages|deploy|\.ci)/[\w./-]+", texts):
        assert (ROOT / path).exists(), path
    for words in re.findall(r"packages/release\.py (\w+)", texts):
        assert words in release.__doc__


def test_workflows_may_do_nothing_but_what_a_job_asks_for() -> None:
    for path in WORKFLOWS:
        found = workflow(path)
        assert found["permissions"] == {"contents": "read"}
        for name, job in found["jobs"].items():
            assert job["timeout-minutes"] <= 150, name
            if "write" in (job.get("permissions") or {}).values() and name != "image":
                assert job.get("if") == "github.ref_type == 'tag'" or "publish" in job["needs"], name
    image = workflow(ROOT / ".github/workflows/release.yml")["jobs"]["image"]["steps"]
    assert [step["if"] for step in image if "TOKEN" in step.get("env", {})] == ["github.ref_type == 'tag'"]


def test_the_matrix_has_the_versions_of_python_that_the_package_names() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = [each.rpartition(" ")[2] for each in project["classifiers"] if re.search(r":: 3\.\d+$", each)]
    jobs = workflow(ROOT / ".github/workflows/tests.yml")["jobs"]
    assert jobs["fast"]["strategy"]["matrix"]["python"] == named
    wheels = workflow(ROOT / ".github/workflows/release.yml")["jobs"]["wheels"]
    assert wheels["strategy"]["matrix"]["system"] == jobs["fast"]["strategy"]["matrix"]["system"]


def test_hooks_before_a_commit_are_checks_that_there_are() -> None:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    (local,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))["repos"]
    entries = [hook["entry"] for hook in local["hooks"]]
    check = (ROOT / "Makefile").read_text(encoding="utf-8")
    for entry in entries:
        assert all((ROOT / path).exists() for path in re.findall(r"\btests/[\w/.]+", entry))
    for words in ("ruff format --check", "ruff check", "pyright", "tests/system/english.py"):
        assert any(words in entry for entry in entries)
        assert words in check


# --- distributions --------------------------------------------------------------------------------


def test_distributions_that_are_incomplete_or_wrong_are_told(tmp_path: Path) -> None:
    check_dist = load("check_dist")
    for name, files in {
        "simx_vrep-1.0.0-cp311-abi3-win_amd64.whl": ["simx_server/a.py", "simx_server/b.pyd", "tests/c.py"],
        "simx_vrep_client-1.0.1-py3-none-any.whl": ["simx_client/a.py", "simx_client/b.so"],
    }.items():
        with zipfile.ZipFile(tmp_path / name, "w") as archive:
            for file in files:
                archive.writestr(file, "")
    assert check_dist.problems(tmp_path) == [
        "there is no gz of simx_vrep",
        "there is no gz of simx_vrep_client",
        "there are several versions: 1.0.0, 1.0.1",
        "simx_vrep-1.0.0-cp311-abi3-win_amd64.whl: puts tests into environments",
        "simx_vrep-1.0.0-cp311-abi3-win_amd64.whl: has 1 compiled modules",
        "simx_vrep_client-1.0.1-py3-none-any.whl: has 1 compiled modules",
    ]
