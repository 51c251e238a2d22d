"""``simx-check``: what an old script wants is read from its text, and compared with a scene."""

from __future__ import annotations

import json
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import pytest
from vrep_writer import VrepWriter

from simx_client import __main__ as program
from simx_client.checking import command, scene
from simx_client.checking.program import read_program
from simx_client.checking.reading.names import names_of
from simx_client.checking.reading.texts import matches
from simx_client.checking.scene import NoScene, SceneView
from simx_client.checking.wants import wants_of

LEGACY = Path(__file__).parents[2] / "old_programs" / "programs"

HEAD = "import vrep\nc = vrep.simxStart('127.0.0.1', 19997, True, True, 5000, 5)\nB = vrep.simx_opmode_blocking\n"


def a_scene(
    *names: str, scripts: dict[str, list[str]] | None = None, signals: list[str] | None = None
) -> SceneView:
    """A scene as the server describes it."""

    def scripts_of(name: str) -> list[dict[str, Any]]:
        if scripts is None or name not in scripts:
            return []
        return [{"type": "child", "file": "a.lua", "functions": scripts[name], "signals": signals or []}]

    objects = [{"name": name, "path": f"/base/{name}", "scripts": scripts_of(name)} for name in names]
    return SceneView(
        {"scene": "lab", "objects": objects, "main_script": [], "registered": {"collision": ["Collision0"]}}
    )


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Any:
    """Checks a text; gives the exit code and the record."""
    monkeypatch.chdir(tmp_path)

    def run(text: str, view: SceneView | None = None) -> tuple[int, dict[str, Any]]:
        (tmp_path / "script.py").write_text(HEAD + textwrap.dedent(text))
        flags = ["--json"]
        if view is not None:
            monkeypatch.setattr(command, "look_at", lambda *_: view)
            flags += ["--scene", "lab.xml"]
        code = command.main(["script.py", *flags])
        return code, json.loads(capsys.readouterr().out)

    return run


def objects_of(record: dict[str, Any]) -> list[str]:
    return [each["name"] for each in record["named"] if each["kind"] == "object"]


def texts_of(record: dict[str, Any], level: str = "problem") -> list[str]:
    return [each["text"] for each in record["findings"] if each["level"] == level]


# --- names that are built -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("H('UR5')", ["UR5"]),
        ("for i in range(6): H('UR5_joint' + str(i+1))", ["UR5_joint*"]),
        ("for i in range(6): H('joint%d' % i)", ["joint*"]),
        ("for i in range(6): H('%s_sensor%02d#' % ('robot', i))", ["robot_sensor*#"]),
        ("for i in range(6): H(f'arm{i}_tip')", ["arm*_tip"]),
        ("for i in range(6): H('arm{}/{name}'.format(i, name='tip'))", ["arm*/tip"]),
        ("for n in ['left', 'right']: H('motor_' + n)", ["motor_left", "motor_right"]),
        ("for i, n in enumerate(('a', 'b')): H(n)", ["a", "b"]),
        ("for k, n in {'x': 'a', 'y': 'b'}.items(): H(k + n)", ["xa", "xb", "ya", "yb"]),
        ("names = ['a' + str(i) for i in range(3)]\nH(names[0])", ["a*"]),
        ("names = []\nnames.append('a')\nfor n in names: H(n)", ["a"]),
        ("a, b = 'x', 'y'\nH(a)\nH(b)", ["x", "y"]),
        ("n = 'a' if c else 'b'\nH(n)", ["a", "b"]),
        ("class R:\n  base = 'R'\n  def go(self):\n    b = self.base\n    H(b + '_tip')", ["R_tip"]),
        (
            "class R:\n  def __init__(self, n):\n    self.n = n\n    H(self.n + '#1')\nR('a'); R(n='b')",
            ["a#1", "b#1"],
        ),
        ("def get(n, m='tip'):\n  H(n + m)\nget('a')", ["atip"]),
        ("import sys\nH(sys.argv[1])", []),
        ("while True:\n  n = n + 'a'\n  H(n)", ["*a"]),
    ],
)
def test_names_are_followed_to_where_they_are_written(check: Any, text: str, names: list[str]) -> None:
    code, record = check(
        text.replace("H(", "vrep.simxGetObjectHandle(operationMode=B, clientID=c, objectName=")
    )
    assert code == 0
    assert sorted(objects_of(record)) == sorted(names)


def test_what_is_known_only_at_run_time_is_said(check: Any) -> None:
    code, record = check("import sys\nvrep.simxGetObjectHandle(c, sys.argv[1], B)")
    assert code == 0
    assert "which object is meant is known only while it runs (line 5)" in texts_of(record, "note")


def test_a_name_is_told_once_with_its_first_line(check: Any) -> None:
    _, record = check("vrep.simxGetObjectHandle(c, 'a', B)\nvrep.simxGetObjectHandle(c, 'a', B)")
    assert [(each["name"], each["line"]) for each in record["named"]] == [("a", 4)]


def test_patterns_match_what_they_may_become() -> None:
    assert matches("UR5_joint*", "UR5_joint1")
    assert matches("*", "")
    assert not matches("UR5_joint*", "UR10_joint1")
    assert not matches("a.b", "axb")


# --- what is called -------------------------------------------------------------------------------


def test_functions_signals_scripts_and_ports_are_listed(check: Any) -> None:
    code, record = check(
        """
        d = vrep.simxStart(connectionAddress='', connectionPort=20000, waitUntilConnected=True,
            doNotReconnectOnceDisconnected=True, timeOutInMs=1, commThreadCycleInMs=5)
        vrep.simxSetFloatSignal(c, 'speed', 1.0, B)
        vrep.simxGetInt32Signal(c, 'ready_' + str(c), B)
        vrep.simxCallScriptFunction(c, 'RG2', vrep.sim_scripttype_childscript, 'rg2Open', [], [], [], b'', B)
        vrep.simxCallScriptFunction(c, '', 1, 'close@RG2', [], [], [], b'', B)
        """
    )
    assert code == 0
    assert record["ports"] == [19997, 20000]
    assert any("--port 20000" in text for text in texts_of(record, "note"))
    assert [(each["type"], each["name"], each["use"]) for each in record["signals"]] == [
        ("float", "speed", "set"),
        ("integer", "ready_*", "get"),
    ]
    assert [(each["object"], each["function"]) for each in record["script_functions"]] == [
        ("RG2", "rg2Open"),
        ("RG2", "close"),
    ]
    assert set(record["functions"]) == {
        "simxStart", "simxSetFloatSignal", "simxGetInt32Signal", "simxCallScriptFunction",
    }  # fmt: skip


def test_functions_and_constants_that_do_not_exist_are_problems(check: Any) -> None:
    code, record = check("vrep.simxGetObjectPositon(c, 1, -1, B)\nvrep.sim_no_such_thing")
    assert code == 1
    assert record["unknown_functions"] == ["simxGetObjectPositon"]
    first, second = texts_of(record)
    assert "did you mean 'simxGetObjectPosition'" in first
    assert "sim_no_such_thing" in second


def test_wrong_number_of_arguments_is_a_problem(check: Any) -> None:
    code, record = check("vrep.simxGetObjectPosition(c, 1, B)\nvrep.simxGetObjectPosition(*[c, 1, B])")
    assert code == 1
    [text] = texts_of(record)
    assert "takes 4 arguments, 3 are given" in text
    assert "relativeToObjectHandle" in text


def test_functions_of_the_scripts_own_are_not_the_apis(check: Any) -> None:
    code, record = check(
        "class W:\n  def simxMine(self, a): vrep.simxGetObjectHandle(c, a, B)\nW().simxMine('own')\nsimx_run()"
    )
    assert code == 0
    assert objects_of(record) == ["own"]


def test_functions_are_known_under_other_names(check: Any) -> None:
    code, record = check(
        "from vrep import simxGetObjectHandle as handle\nhandle(c, 'a', B)\n"
        "getattr(vrep, 'simxGetObjectHandle')(c, 'b', B)\ngetattr(vrep, c)(1)"
    )
    assert (code, objects_of(record)) == (0, ["a", "b"])


def test_calls_in_a_batch_have_no_client_id_and_no_mode(check: Any) -> None:
    code, record = check("def look(calls):\n  calls.simxGetObjectHandle('a')")
    assert (code, objects_of(record)) == (0, ["a"])


def test_numbered_differences_are_data(check: Any) -> None:
    _, record = check("vrep.simxGetJointForce(c, 4, B)")
    [first] = record["differences"]
    assert (first["number"], first["functions"]) == (65, ["simxGetJointForce"])
    assert first["text"].startswith("The first simxGetJointForce of a run")


def test_modules_beside_the_script_are_read_and_its_binding_is_not(check: Any, tmp_path: Path) -> None:
    (tmp_path / "robot.py").write_text(
        HEAD + "class Robot:\n  def __init__(s, n): vrep.simxGetObjectHandle(c, n, B)"
    )
    (tmp_path / "vrep.py").write_text("simx_opmode_oneshot = 0\ndef simxNoSuch(): pass\nsimxNoSuch()")
    code, record = check("import robot, surely_not_installed\nrobot.Robot('far')")
    assert code == 0
    assert objects_of(record) == ["far"]
    assert [Path(each).name for each in record["files"]] == ["script.py", "robot.py"]
    assert any("surely_not_installed is not installed" in text for text in texts_of(record, "note"))


# --- what a scene lacks ---------------------------------------------------------------------------


def test_missing_objects_are_problems_with_the_nearest_names(check: Any) -> None:
    text = """
    for name in ['UR5_joint1#', '/base/RG2', 'RG3', 'Ball@silentError']:
        vrep.simxGetObjectHandle(c, name, B)
    for i in range(9):
        vrep.simxGetObjectHandle(c, 'UR5_joint%d' % i, B)
        vrep.simxGetObjectHandle(c, 'leg%d' % i, B)
    """
    code, record = check(text, a_scene("UR5_joint1", "RG2"))
    assert code == 1
    problems = texts_of(record)
    assert len(problems) == 3
    assert any("no object 'RG3' in lab; nearest: RG2; rename one" in text for text in problems)
    assert any("'Ball@silentError'" in text for text in problems)
    assert any("no object is called like 'leg*'" in text for text in problems)


def test_what_a_script_loads_may_bring_what_is_missing(check: Any) -> None:
    text = "vrep.simxLoadModel(c, 'arm.ttm', 0, B)\nvrep.simxGetObjectHandle(c, 'arm', B)"
    code, record = check(text, a_scene("base"))
    assert code == 0
    assert any("may come with what the script loads" in text for text in texts_of(record, "note"))


def test_scripts_functions_and_registered_names_must_be_there(check: Any) -> None:
    def call(owner: str, function: str) -> str:
        return f"vrep.simxCallScriptFunction(c, '{owner}', 1, '{function}', [], [], [], b'', B)\n"

    text = (
        call("RG2", "rg2Open") + call("RG2", "rg2Shut") + call("base", "go")
        + call("remoteApiCommandServer", "x")
        + "vrep.simxGetCollisionHandle(c, 'Collision0', B)\nvrep.simxGetCollisionHandle(c, 'Collision1', B)"
    )  # fmt: skip
    code, record = check(text, a_scene("base", "RG2", scripts={"RG2": ["rg2Open", "rg2Close"]}))
    assert code == 1
    assert sorted(text.partition(";")[0] for text in texts_of(record)) == [
        "'base' has no script in lab, and go is called there",
        "no collision 'Collision1' in lab",
        "no object 'remoteApiCommandServer' in lab",
        "the script of 'RG2' has no function rg2Shut",
    ]


def test_signals_that_nobody_sets_are_noted(check: Any) -> None:
    text = """
    vrep.simxSetStringSignal(c, 'mine', 'x', B)
    vrep.simxGetStringSignal(c, 'mine', B)
    vrep.simxGetFloatSignal(c, 'gyroX', B)
    vrep.simxGetFloatSignal(c, 'nobodys', B)
    """
    code, record = check(text, a_scene("a", scripts={"a": []}, signals=["gyro*"]))
    assert code == 0
    [note] = texts_of(record, "note")
    assert "'nobodys' is read" in note


# --- real ones ------------------------------------------------------------------------------------


def test_a_python_2_script_is_read_with_its_own_lines(capsys: pytest.CaptureFixture[str]) -> None:
    program_ = read_program(LEGACY / "pioneer_avoid.py")
    wants = wants_of(program_, names_of(program_))
    assert program_.script.is_python2
    lines = (LEGACY / "pioneer_avoid.py").read_text().splitlines()
    assert all(name in lines[place.line - 1] for name, place in wants.functions.items())
    assert {each.name for each in wants.of_kind("object")} == {
        "Pioneer_p3dx", "Pioneer_p3dx_leftMotor", "Pioneer_p3dx_rightMotor", "Pioneer_p3dx_ultrasonicSensor*",
    }  # fmt: skip


@pytest.mark.usefixtures("started_servers")
def test_a_real_scene_is_looked_at_and_the_page_is_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    code = program.main(
        ["check", str(LEGACY / "pendulum_torque.py"), "--scene", str(LEGACY / "pendulum.xml")]
    )
    page = capsys.readouterr().out
    assert code == 0
    assert "  objects     pendulum_joint\n" in page
    assert page.endswith("nothing is missing in pendulum\n")
    assert "\x1b" not in page


def test_what_cannot_be_checked_is_wrong_use(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert command.main([str(tmp_path / "no.py")]) == 2
    assert "cannot open" in capsys.readouterr().err
    bad = tmp_path / "bad.py"
    bad.write_text("x = (\n")
    assert command.main([str(bad)]) == 2
    assert "bad.py, line 1, is no Python" in capsys.readouterr().err

    def nothing(*_: object) -> SceneView:
        raise NoScene("the scene no.xml cannot be looked at: no scene 'no.xml'")

    monkeypatch.setattr(command, "look_at", nothing)
    assert command.main([str(LEGACY / "two_clients.py"), "--scene", "no.xml"]) == 2
    assert "no scene 'no.xml'" in capsys.readouterr().err


def test_a_scene_that_is_not_there_is_told_in_the_servers_words(monkeypatch: pytest.MonkeyPatch) -> None:
    told = subprocess.CompletedProcess[str]([], 1, "", '{"message": "no scene x; shipped scenes: y"}\n')
    monkeypatch.setattr(scene.subprocess, "run", lambda *_, **__: told)
    with pytest.raises(NoScene, match="looked at: no scene x; shipped scenes: y"):
        scene.look_at("x")


def test_checking_loads_neither_the_server_nor_numpy() -> None:
    code = (
        "import sys\nfrom simx_client.checking import command\n"
        "assert not {'simx_server', 'mujoco', 'numpy', 'cv2', 'zenoh'} & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


# --- V-REP's own scenes ---------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A script beside two scenes; the working folder is another one."""
    place, elsewhere = tmp_path / "project", tmp_path / "elsewhere"
    place.mkdir()
    elsewhere.mkdir()
    writer = VrepWriter(21)
    base = writer.shape("Base", cuboid=(0.2, 0.2, 0.1))
    writer.joint("motor", parent=base)
    writer.settings()
    (place / "robot.ttt").write_bytes(writer.bytes())
    (place / "old robot.ttt").write_bytes(writer.bytes())
    text = "vrep.simxGetObjectHandle(c, 'motor', B)\nvrep.simxGetCollectionHandle(c, 'links', B)\n"
    (place / "drive.py").write_text(HEAD + text)
    monkeypatch.chdir(elsewhere)
    return place


def test_vrep_scene_beside_the_script_is_looked_at(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main([str(folder / "drive.py"), "--scene", "robot.ttt"]) == 1
    page = capsys.readouterr().out
    assert "'motor'" not in page
    assert "no collection 'links' in robot" in page
    assert "in the MJCF that `simx-server robot.ttt --convert FOLDER` writes" in page


@pytest.mark.parametrize(
    ("loaded", "meant"),
    [("", "SCENE"), ("C:\\\\x\\\\robot.ttt", "robot.ttt"), ("old robot.ttt", "'old robot.ttt'")],
)
def test_scene_that_the_script_loads_is_suggested_if_it_lies_beside_it(
    folder: Path, capsys: pytest.CaptureFixture[str], loaded: str, meant: str
) -> None:
    script = folder / "drive.py"
    if loaded:
        script.write_text(script.read_text() + f"vrep.simxLoadScene(c, '{loaded}', 0, B)\n")
    assert command.main([str(script)]) == 0
    assert f"--scene {meant} compares" in capsys.readouterr().out
