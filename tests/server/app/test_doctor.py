"""``simx-server --doctor``: what it finds, what it advises, and that nothing it tries can end it."""

from __future__ import annotations

import io
import json
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from simx_client.protocol.cli import installing
from simx_client.protocol.cli.terminal import Paint
from simx_server.app import cli
from simx_server.app.doctor import child, graphics, machine, network, page
from simx_server.app.doctor.child import ProbeFailed, run_probe
from simx_server.app.doctor.findings import LEVELS, OK, PROBLEM, WARNING, Finding
from simx_server.joints.native import loading as joints_loading
from simx_server.kinematics.least_squares.native import loading as kinematics_loading
from simx_server.scene.formats.vrep.native import loading as compression_loading
from simx_server.sensors.distance.native import loading as distances_loading
from simx_server.sensors.proximity.native import loading as rays_loading
from simx_server.settings.settings import Settings

pytestmark = pytest.mark.gl

SCENE = """
<mujoco>
  <worldbody>
    <light pos="0 0 5"/>
    <body name="ball"><geom size="0.3" rgba="1 0 0 1"/></body>
    <camera name="eye" pos="0 0 9" xyaxes="0 1 0 0 0 1" resolution="32 24"/>
  </worldbody>
</mujoco>
"""


@pytest.fixture
def port() -> Iterator[int]:
    """One that somebody listens on: this process."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen(1)
        yield listener.getsockname()[1]


def backends(*working: str) -> list[Finding]:
    def probe(name: str, give_up: threading.Event) -> str | None:
        return None if name in working else "no such library"

    return list(graphics.check_backends(probe))


def level_of(findings: list[Finding], words: str) -> str:
    [level] = [each.level for each in findings if words in each.text]
    return level


def test_everything_is_looked_at_and_the_exit_code_says_whether_it_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], port: int
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    monkeypatch.setattr(graphics, "candidates", lambda: ("egl",))
    scene = tmp_path / "ball.xml"
    scene.write_text(SCENE)
    arguments = [str(scene), "--doctor", "--json", "--port", str(port), "--workspace", str(tmp_path)]
    assert cli.main(arguments) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["works"] is True
    found: dict[str, list[dict[str, Any]]] = {}
    for each in record["findings"]:
        assert each["level"] in LEVELS
        found.setdefault(each["topic"], []).append(each)
    assert list(found) == [
        "python", "packages", "extras", "cores", "memory", "physics steps", "distances", "rays", "inverse kinematics",
        "V-REP's compression", "workspace", "port", "zenoh", "graphics", "image",
    ]  # fmt: skip
    assert found["zenoh"][0]["level"] == OK
    [image] = found["image"]
    assert image["level"] == OK
    assert (
        "eye of ball, 32x24 with raycast" in image["text"]
    )  # turned to the ball, which its own pose does not see
    [taken] = found["port"]
    assert taken["level"] == WARNING
    if sys.platform == "linux":
        assert f"{port} is taken by process " in taken["text"]


def test_any_problem_is_exit_code_1_and_people_see_what_to_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = [Finding(OK, "python", "here"), Finding(PROBLEM, "zenoh", "silent " * 20, "ask somebody")]
    monkeypatch.setattr(page, "checks", lambda settings: [lambda: bad])
    assert page.print_findings(Settings(), as_json=False) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "ok       python         here"
    assert lines[1].startswith("problem  zenoh          silent")
    assert lines[-2] == " " * 24 + "-> ask somebody"
    assert lines[-1] == "the server will not work well here: 1 problem"
    assert max(map(len, lines)) <= page.WIDTH


def test_summary_counts_and_colours() -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    plain = Paint(io.StringIO())
    assert page.summary([Finding(OK, "a", "")], plain) == "the server works here"
    warnings = [Finding(WARNING, "a", "")] * 2
    assert page.summary(warnings, plain) == "the server works here: 2 warnings"
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("TERM", "xterm")
        environment.delenv("NO_COLOR", raising=False)
        assert "\x1b[33mwarning" in page.as_lines(warnings[0], Paint(Terminal()))[0]


# --- graphics -------------------------------------------------------------------------------------


def test_one_working_back_end_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(graphics, "candidates", lambda: ("egl", "osmesa"))
    found = backends("osmesa")
    assert [each.level for each in found] == [OK, OK]
    assert level_of(found, "egl cannot render: no such library") == OK


def test_without_any_rays_are_cast_and_each_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(graphics, "candidates", lambda: ("egl", "osmesa"))
    found = backends()
    assert [each.level for each in found] == [WARNING] * 3
    assert "libegl1" in found[0].advice
    assert "libosmesa6" in found[1].advice
    assert "casting rays" in found[2].text


def test_a_back_end_that_is_asked_for_must_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(graphics, "candidates", lambda: ("egl", "osmesa"))
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    found = backends("egl")
    assert level_of(found, "MUJOCO_GL asks for osmesa") == PROBLEM
    assert all("unset MUJOCO_GL" in each.advice for each in found if each.level == PROBLEM)
    monkeypatch.setenv("MUJOCO_GL", "vulkan")
    [finding] = backends("egl")
    assert finding.level == PROBLEM
    assert "vulkan" in finding.text


def test_a_blank_image_is_a_warning_and_none_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: dict[str, Any] = {
        "scene": "s", "sensor": "eye", "backend": "egl", "width": 4, "height": 3, "colours": 1, "darkest": 0,
        "brightest": 0, "covered": 0.0, "milliseconds": 1.0, "solver": "",
    }  # fmt: skip
    monkeypatch.setattr(graphics, "run_probe", lambda *_, **__: seen)
    [finding] = graphics.check_scene(None)
    assert finding.level == WARNING
    assert "blank" in finding.text
    seen |= {"sensor": None, "solver": "MuJoCo solves it wrongly"}
    solver, image = graphics.check_scene(None)
    assert (solver.level, solver.text, image.level) == (WARNING, "MuJoCo solves it wrongly", OK)

    def crash(*_: object, **__: object) -> dict[str, Any]:
        raise ProbeFailed("its process was ended by signal 11")

    monkeypatch.setattr(graphics, "run_probe", crash)
    [finding] = graphics.check_scene(None)
    assert finding.level == PROBLEM
    assert "signal 11" in finding.text


# --- processes of their own -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("done", "says"),
    [
        (subprocess.CompletedProcess[str]([], -11, "", ""), "signal 11"),
        (subprocess.CompletedProcess[str]([], 1, "", "first\nno library\n"), "no library"),
        (subprocess.CompletedProcess[str]([], 3, "", ""), "exit status 3"),
        (subprocess.CompletedProcess[str]([], 0, "", ""), "exit status 0"),
        (subprocess.TimeoutExpired("probe", 1), "no answer within 1 s"),
    ],
)
def test_a_probe_may_end_in_any_way(
    monkeypatch: pytest.MonkeyPatch, done: subprocess.CompletedProcess[str] | Exception, says: str
) -> None:
    def run(*_: object, **__: object) -> subprocess.CompletedProcess[str]:
        if isinstance(done, Exception):
            raise done
        return done

    monkeypatch.setattr(child.subprocess, "run", run)
    with pytest.raises(ProbeFailed, match=says):
        run_probe("some.module", timeout=1)


def test_zenoh_talks_where_no_shared_memory_may_be_made() -> None:
    program = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"
        "from simx_server.app.doctor.zenoh_probe import main; raise SystemExit(main())"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


def test_silent_zenoh_is_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    def silent(*_: object, **__: object) -> dict[str, Any]:
        raise ProbeFailed("no answer within 5 s")

    monkeypatch.setattr(network, "run_probe", silent)
    finding = network.check_zenoh()
    assert finding.level == PROBLEM
    assert "loopback" in finding.advice


# --- the machine ----------------------------------------------------------------------------------


def test_missing_packages_and_extras_say_how_to_install_them() -> None:
    requirements = [
        "numpy<3,>=1.26", "surely-not-there>=1", "also-not-there; extra == 'learning'", "pytest; extra == 'dev'",
    ]  # fmt: skip
    problem, there, extra = machine.check_packages(requirements)
    assert (problem.level, problem.advice) == (PROBLEM, installing.line(["surely-not-there>=1"]))
    assert there.text.startswith("numpy ")
    assert extra.level == OK
    assert extra.advice == f"if you want it: {installing.line(['also-not-there'])}"


def test_old_python_is_a_problem(monkeypatch: pytest.MonkeyPatch) -> None:
    assert machine.check_python().level == OK
    monkeypatch.setattr(machine, "LEAST_PYTHON", (9, 0))
    finding = machine.check_python()
    assert (finding.level, "9.0" in finding.advice) == (PROBLEM, True)


def test_little_memory_is_a_warning() -> None:
    assert machine.check_memory(100 << 20).level == WARNING
    assert machine.check_memory(4 << 30).level == OK


@pytest.mark.parametrize(
    ("place", "loading"),
    list(
        enumerate((joints_loading, distances_loading, rays_loading, kinematics_loading, compression_loading))
    ),
)
def test_a_compiled_form_that_is_not_used_is_a_warning_with_the_reason(
    place: int, loading: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    finding = machine.check_compiled_forms()[place]
    assert (finding.level == OK) == (loading.form().module is not None)
    monkeypatch.setenv(loading.VARIABLE, "python")
    finding = machine.check_compiled_forms()[place]
    assert (finding.level, finding.text) == (WARNING, f"in Python: {loading.VARIABLE} is python")
    assert "gcc python3-dev, then install simx again" in finding.advice


def test_workspace_that_cannot_be_written_is_a_warning(tmp_path: Path) -> None:
    assert machine.check_workspace(tmp_path).level == OK
    assert list(tmp_path.iterdir()) == []
    finding = machine.check_workspace(tmp_path / "gone")
    assert finding.level == WARNING
    assert "--workspace" in finding.advice


def test_free_ports_are_ok_and_0_is_not_looked_at(port: int) -> None:
    with socket.socket() as place:
        place.bind(("127.0.0.1", 0))
        free = place.getsockname()[1]
    assert [each.level for each in network.check_ports([free, 0, port])] == [OK, WARNING]
