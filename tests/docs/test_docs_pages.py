"""The pages of docs/ say what is so: their files, programs and outputs are tried, their links lead somewhere."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import cv2
import pytest
from processes import ROOT, ServerProcess, server
from real_world import RealWorld

import simx_client as v
from simx_client.checking import command as check
from simx_client.transport.redirect import VARIABLE, format_redirects
from simx_server.app import cli
from simx_server.files.library import list_scenes
from simx_server.joints.state import bind, initial_state
from simx_server.scene.formats.annotations import GRAMMAR
from simx_server.scene.formats.loader import load_scene, load_text
from simx_server.settings.gathering import gather
from simx_server.viewer.page import command as view_command

pytestmark = pytest.mark.slow

DOCS = ROOT / "docs"
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
BLOCK = re.compile(r"^```(\w+)(?: ([^\n]+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def page(name: str) -> str:
    return (DOCS / name).read_text(encoding="utf-8")


def blocks(name: str) -> list[tuple[str, str, str]]:
    """Language, the rest of the opening line, text."""
    return BLOCK.findall(page(name))


# --- porting -------------------------------------------------------------------------------------


@pytest.fixture
def ported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The page's files lie in the present folder; what it shows as printed, per command line."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MUJOCO_GL", "disable")
    printed: dict[str, str] = {}
    for language, title, text in blocks("porting.md"):
        if language == "text":
            printed[title] = text
        else:
            Path(title).write_text(text, encoding="utf-8")
    return printed


def test_porting_page_prints_what_the_programs_print(
    ported: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    mains = {"simx-check": check.main, "simx-server": cli.main}
    tried = 0
    for line, shown in ported.items():
        program, *arguments = shlex.split(line)
        if program in mains:
            assert mains[program](arguments) == 0
            assert shown in capsys.readouterr().out, line
            tried += 1
    assert tried == 3


def test_porting_page_program_runs_unchanged_on_its_scene(ported: dict[str, str]) -> None:
    (line,) = [line for line in ported if line.startswith("simx-run ")]
    done = subprocess.run(
        [sys.executable, "-m", "simx_client", "run", *shlex.split(line)[1:]],
        capture_output=True, text=True, timeout=60, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, ported[line]), done.stderr


def test_porting_page_scene_has_a_shipped_robot_twice(ported: dict[str, str]) -> None:
    scene, _ = load_scene("two_robots.xml")
    for copy in ("", "#0"):
        assert scene.by_name(f"Pioneer_p3dx_leftMotor{copy}") is not None


def test_porting_page_what_is_missing_is_a_problem(
    ported: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    scene = Path("car.xml").read_text(encoding="utf-8")
    Path("car.xml").write_text(scene.replace('"leftMotor"', '"motorLeft"'), encoding="utf-8")
    assert check.main(["drive.py", "--scene", "car.xml"]) == 1
    assert "problem: no object 'leftMotor' in car" in capsys.readouterr().out


# --- annotations ---------------------------------------------------------------------------------

SECTIONS = dict(re.findall(r"^## (\w+)\n(.*?)(?=^## |\Z)", page("annotations.md"), re.MULTILINE | re.DOTALL))
BENCH = next(text for _, title, text in blocks("annotations.md") if title)
EXAMPLES = [text for _, title, text in blocks("annotations.md") if not title]
SHORT_FORMS = dict(
    re.findall(r"^\| ([^|`]+) \| (.+) \|$", page("annotations.md").partition("\n## ")[0], re.MULTILINE)
)
"""The table at the top of the page: short form of a valid value to what the error text says."""


def rows(section: str) -> dict[str, tuple[str, ...]]:
    """Key to the other cells of its row."""
    lines = re.findall(r"^\| `(\w+)` \|(.*)\|$", section, re.MULTILINE)
    return {key: tuple(cell.strip() for cell in rest.split("|")) for key, rest in lines}


def what_is_valid(check_value: Callable[[str], object]) -> str:
    """The error text of a wrong value; -7 is wrong except for a number that may have any sign."""
    for wrong in ("-7", "?"):
        try:
            check_value(wrong)
        except ValueError as error:
            return str(error)
    raise AssertionError("takes everything")


@pytest.mark.parametrize("kind", GRAMMAR)
def test_annotations_page_has_every_key_with_what_is_valid(kind: str) -> None:
    table = rows(SECTIONS[kind])
    assert list(table) == list(GRAMMAR[kind])
    for key, check_value in GRAMMAR[kind].items():
        valid, without, meaning = table[key]
        assert all((valid, without, meaning)), key
        if check_value is not str:
            assert SHORT_FORMS.get(valid, valid) == what_is_valid(check_value), key


def test_annotations_page_has_a_section_for_each_kind_and_no_other() -> None:
    assert set(SECTIONS) == set(GRAMMAR)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda text: re.findall(r'name="(.*?)"', text)[0])
def test_annotations_page_example_loads(
    example: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    (tmp_path / "arm.lua").write_text("function sysCall_init() end")
    (tmp_path / "panel.toml").write_text('[[ui]]\nname = "panel"\n')
    (tmp_path / "bench.xml").write_text(BENCH.replace("<custom>\n", f"<custom>\n{example}"))
    world = RealWorld(tmp_path / "bench.xml")
    try:
        world.simulation.start()
        world.parts.step()
    finally:
        world.close()


def test_annotations_page_defaults_of_joints_are_those_of_the_code() -> None:
    scene, model = load_text(
        BENCH.replace("<custom>\n", '<custom><text name="simx:joint:finger" data="cyclic=no"/>')
    )
    finger = next(item for item in scene.objects.values() if item.name == "finger")
    state = initial_state(finger, bind(finger, model), model, 0.0, {})
    table = rows(SECTIONS["joint"])
    shown = {key: table[key][1] for key in ("P", "I", "D", "target_velocity", "offset", "multiplication")}
    assert shown == {
        "P": f"{state.p:g}", "I": f"{state.i:g}", "D": f"{state.d:g}",
        "target_velocity": f"{state.target_velocity:g}", "offset": f"{state.offset:g}",
        "multiplication": f"{state.factor:g}",
    }  # fmt: skip
    switches = {key: table[key][1] for key in ("lock", "hybrid", "rewind")}
    assert switches == {key: "on" if getattr(state, key) else "off" for key in switches}
    assert table["mode"][1] == state.mode.name.lower()


# --- modes and cameras ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServerProcess]:
    scene = tmp_path_factory.mktemp("room") / "room.xml"
    scene.write_text(next(text for _, title, text in blocks("cameras.md") if title == "room.xml"))
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("MUJOCO_GL", "disable")
        with server(scene) as process:
            yield process


@pytest.mark.parametrize("name", ["modes.md", "cameras.md", "performance.md"])
def test_programs_of_a_page_run(name: str, room: ServerProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, format_redirects({19997: ("127.0.0.1", room.port)}))
    programs = [text for language, _, text in blocks(name) if language == "python"]
    assert len(programs) > 1
    variables = vars(ModuleType("page"))
    try:
        for program in programs:
            exec(compile(program, f"docs/{name}", "exec"), variables)
    finally:
        v.simxFinish(-1)


_FENCED = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
_INDENTED = re.compile(r"(?:^    .*\n(?:^\s*\n)*)+", re.MULTILINE)

WITH_A_CLIENT = ("user-interface.md",)
"""Pages whose indented programs use the variables of the programs before them: `client`, an id, and `vrep`."""

NEED_MORE = ("recording.md", "view.md", "pyrep.md")
"""Pages whose indented programs need a recording, a notebook, and PyRep with its scenes."""


def indented_programs(name: str) -> list[str]:
    """The indented blocks of a page that are whole programs in Python: they start with an import."""
    found = map(textwrap.dedent, _INDENTED.findall(_FENCED.sub("", page(name))))
    return [text for text in found if re.match(r"(import|from) \w", text)]


def test_indented_programs_run(room: ServerProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    pages = [name for name in PAGES if indented_programs(name)]
    assert set(pages) >= {"embedded.md", *WITH_A_CLIENT, *NEED_MORE}
    for name in set(pages) - set(NEED_MORE):
        variables = vars(ModuleType("page"))
        if name in WITH_A_CLIENT:
            variables["client"] = v.simxStart("127.0.0.1", room.port, True, True, 5000, 5)
        try:
            for program in indented_programs(name):
                exec(compile(program, f"docs/{name}", "exec"), variables)
        finally:
            v.simxFinish(-1)


# --- the page in the browser ---------------------------------------------------------------------


def test_view_page_has_every_tab() -> None:
    composition = (ROOT / "simx_server" / "viewer" / "page" / "composition.py").read_text(encoding="utf-8")
    tabs = page("view.md").partition("\n## Keys\n")[0]
    shown = re.findall(r"^\| (\w+) \|", tabs, re.MULTILINE)
    assert shown[1:] == re.findall(r'add_tab\("(\w+)"\)', composition)


def test_view_page_has_every_key() -> None:
    source = (ROOT / "simx_server/viewer/page/tools/shortcuts.py").read_text(encoding="utf-8")
    keys = page("view.md").partition("\n## Keys\n")[2].partition("\n## ")[0]
    shown = re.findall(r"^\| ([^|]+) \|", keys, re.MULTILINE)
    named = {word for cell in shown[1:] for word in re.split(r",? ", cell)}
    assert {"Space", "0", "Home"} <= named
    assert set(re.findall(r'Shortcut\("[^"]+", "([^"]+)"', source)) <= named


def test_view_page_commands_are_understood(capsys: pytest.CaptureFixture[str]) -> None:
    lines = re.findall(
        r"^    (?:ssh .* )?(simx-server|python -m simx_server\.viewer) ?(.*)$", page("view.md"), re.MULTILINE
    )
    assert len(lines) == 6
    for program, rest in lines:
        arguments = shlex.split(re.split(r" {2,}", rest)[0])
        if program == "simx-server":
            flags = vars(cli.make_parser().parse_args(arguments))
            assert gather({"view": flags["view"]}, {}).view
        else:
            with pytest.raises(SystemExit) as left:
                view_command.main([*arguments, "--help"])
            assert left.value.code == 0


# --- all pages -----------------------------------------------------------------------------------


def anchors(text: str) -> set[str]:
    """Of the headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {
        re.sub(r"[^\w\- ]", "", re.sub(r"`", "", title)).strip().lower().replace(" ", "-") for title in titles
    }


@pytest.mark.parametrize("name", [*PAGES, "../README.md"])
def test_links_lead_somewhere(name: str) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", page(name), flags=re.DOTALL)):
        if "://" in target:
            continue
        file, _, anchor = target.partition("#")
        path = (DOCS / name).parent / file if file else DOCS / name
        assert path.exists(), target
        if anchor:
            assert anchor in anchors(path.read_text(encoding="utf-8")), target


def test_index_has_every_page_once() -> None:
    linked = re.findall(r"^\d+\. \[[^]]+\]\((\S+)\)", page("index.md"), re.MULTILINE)
    assert sorted(linked) == sorted({*PAGES, "../README.md"} - {"index.md"})


@pytest.mark.parametrize("name", ["internals/architecture.md", "../CONTRIBUTING.md"])
def test_files_that_a_page_for_developers_names_are_there(name: str) -> None:
    text = page(name)
    for path in set(re.findall(r"`(simx_\w+/[\w/]+(?:\.py)?)/?`", text)):
        assert (ROOT / path).exists(), path
    places = (
        ROOT,
        ROOT / "simx_server",
        ROOT / "simx_client",
        ROOT / "simx_client" / "protocol",
        ROOT / "tests",
    )
    for path in re.findall(r"`((?:\w+/)*\w+\.py|(?:\w+/)+)`", text):
        assert any((place / path).exists() for place in places), path


def test_site_has_every_page() -> None:
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:")[2]
    assert sorted(re.findall(r"[\w/-]+\.md", nav)) == sorted([*PAGES, "start.md"])


@pytest.mark.skipif(find_spec("mkdocs") is None, reason="mkdocs is not installed")
def test_site_builds_without_a_warning(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", tmp_path],
        capture_output=True, text=True, cwd=ROOT, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert "MuJoCo" in (tmp_path / "start" / "index.html").read_text(encoding="utf-8")


def test_drawing_is_the_one_that_its_program_makes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = spec_from_file_location("drawings", DOCS / "drawings.py")
    assert spec is not None
    assert spec.loader is not None
    drawings = module_from_spec(spec)
    spec.loader.exec_module(drawings)
    monkeypatch.setattr(drawings, "FILE", tmp_path / "camera.png")
    made, shown = cv2.imread(str(drawings.draw())), cv2.imread(str(DOCS / "pictures" / "camera.png"))
    assert made is not None
    assert shown is not None
    # Fonts and edges may differ a little from one OpenCV to the next.
    assert (cv2.absdiff(made, shown) > 40).mean() < 0.02


def test_the_gallery_has_a_small_picture_and_a_command_for_each_scene() -> None:
    text = page("gallery.md")
    files = {path.stem: path.stat().st_size for path in (DOCS / "pictures" / "gallery").iterdir()}
    assert sorted(files) == sorted(list_scenes())
    assert max(files.values()) <= 30_000
    assert sum(files.values()) <= 700_000
    for scene in files:
        row = rf"^\| !\[{scene}\]\(pictures/gallery/{scene}\.webp\) \| .+ \| `simx-server {scene} --view` \|$"
        assert len(re.findall(row, text, re.MULTILINE)) == 1, scene
