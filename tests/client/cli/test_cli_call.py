"""``python -m simx_client call``, ``watch`` and ``image``: a simulator driven from a shell."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from processes import ServerProcess, server
from routers import free_port

from simx_client import __main__ as program
from simx_client.cli import call, image, watch
from simx_client.cli.one_call import parse_words
from simx_client.cli.values.arguments import WrongUse, bare, command_named, parse, shielded, usage
from simx_client.cli.values.formatting import as_text
from simx_client.cli.values.png import png, samples_16

pytestmark = pytest.mark.slow

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.02"/>
    </body>
    <body name="box" pos="5 0 0"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
    <geom name="above" type="box" size="0.5 0.1 0.3" pos="0 5 0.3" rgba="1 0 0 1"/>
    <geom name="below" type="box" size="0.5 0.1 0.3" pos="0 5 -0.3" rgba="0 0 1 1"/>
    <camera name="eye" pos="0 3 0" xyaxes="1 0 0 0 0 1" resolution="32 24"/>
  </worldbody>
  <actuator><velocity name="hinge" joint="hinge" kv="10"/></actuator>
  <custom>
    <text name="simx:lua:arm" data="function twice(i,f,s,b) return {2*i[1]},{f[1]},{s[1]},b end"/>
  </custom>
</mujoco>
"""


@pytest.fixture(scope="module", autouse=True)
def own_notes(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Servers of other programs on this machine are none of these tests' business."""
    with pytest.MonkeyPatch.context() as environment:
        environment.setenv("XDG_RUNTIME_DIR", str(tmp_path_factory.mktemp("runtime")))
        environment.setenv("MUJOCO_GL", "disable")  # rays find the same colours, and start at once
        yield


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory, own_notes: None) -> Iterator[ServerProcess]:
    """A server called lab, the only one of this host, that runs."""
    scene = tmp_path_factory.mktemp("scene") / "lab.xml"
    scene.write_text(SCENE)
    with server(scene, "--realm", "lab", "--start") as process:
        yield process


def run(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = program.main(list(map(str, arguments)))
    said = capsys.readouterr()
    return code, said.out, said.err


# --- call -----------------------------------------------------------------------------------------


def test_a_name_stands_for_its_handle_and_the_value_is_printed(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    code, by_name, _ = run(capsys, "call", "simxGetObjectPosition", "arm")
    assert (code, by_name) == (0, "0,0,1\n")
    _, handle, _ = run(capsys, "call", "simxGetObjectHandle", "arm")
    assert run(capsys, "call", "simxGetObjectPosition", int(handle), "-1")[1] == by_name


def test_what_is_printed_can_be_given_back(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "call", "simxSetObjectPosition", "box", "-1", "-5,0.25,1e-1")[:2] == (0, "")
    assert run(capsys, "call", "simxGetObjectPosition", "box")[1] == "-5,0.25,0.1\n"


@pytest.mark.parametrize("form", ["{port}", "127.0.0.1:{port}", "lab", "lab@127.0.0.1:{port}"])
def test_place_may_be_said_in_many_ways(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], form: str
) -> None:
    place = form.format(port=lab.port)
    assert run(capsys, "call", "--at", place, "simxGetObjectPosition", "arm")[:2] == (0, "0,0,1\n")


def test_scripts_are_called_with_lists_and_constants(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["arm", "sim_scripttype_childscript", "twice", "-21", "0.5", "text", "bytes"]
    code, lines, _ = run(capsys, "call", "simxCallScriptFunction", *arguments)
    assert code == 0
    assert lines.splitlines() == [
        "outputInts=-42",
        "outputFloats=0.5",
        "outputStrings=text",
        "outputBuffer=bytes",
    ]
    _, text, _ = run(capsys, "call", "simxCallScriptFunction", *arguments, "--json")
    assert json.loads(text)["results"] == {
        "outputInts": [-42],
        "outputFloats": [0.5],
        "outputStrings": ["text"],
        "outputBuffer": "bytes",
    }


def test_refusal_is_the_servers_sentence(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, error = run(capsys, "call", "simxGetJointPosition", "hinqe")
    assert (code, out) == (1, "")
    assert "no object named 'hinqe'" in error
    assert "hinge" in error
    code, out, error = run(capsys, "call", "simxGetJointPosition", "arm", "--json")
    assert code == 1
    record = json.loads(out)
    assert record["code"] == 8
    assert record["error"] in error
    assert "joint" in record["error"]


def test_functions_of_the_client_work_too(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    code, line, _ = run(capsys, "call", "simxGetPingTime")
    assert code == 0
    assert line.strip().isdecimal()


def test_nobody_there_is_a_failure_with_the_way_out(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, error = run(capsys, "call", "simxGetPingTime", "--at", free_port(), "--timeout", "0.5")
    assert (code, out) == (1, "")
    assert "start one with simx-server" in error


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["simxGetJointPositoin", "hinge"], "did you mean 'simxGetJointPosition'"),
        (["GetJointPosition", "hinge"], "did you mean 'simxGetJointPosition'"),
        (["simxPackInts", "1,2"], "asks the server for nothing"),
        (["simxGetJointPosition"], "jointHandle is missing"),
        (["simxGetJointPosition", "a", "b"], "2 arguments were given"),
        (["simxSetJointTargetPosition", "hinge", "fast"], "targetPosition cannot be 'fast'; valid: a number"),
        (["simxSetObjectPosition", "box", "-1", "1,2"], "position has 3 numbers, 2 were given: '1,2'"),
        (["simxSetBooleanParameter", "16", "perhaps"], "valid: yes or no"),
        (["simxAuxiliaryConsoleShow", "console", "yes"], "consoleHandle cannot be 'console'"),
    ],
)
def test_wrong_words_are_wrong_use_before_anybody_is_asked(
    capsys: pytest.CaptureFixture[str], words: list[str], says: str
) -> None:
    code, out, error = run(capsys, "call", *words, "--at", 1)
    assert (code, out) == (2, "")
    assert says in error


def test_words_become_arguments_by_their_kinds() -> None:
    def look_up(finder: str, name: str) -> int:
        return {"simxGetObjectHandle": 7, "simxGetUIHandle": 9}[finder]

    def read(function: str, *words: str) -> list[object]:
        return parse(command_named(function), words, look_up)

    assert read("simxCopyPasteObjects", "a,12,sim_handle_all") == [[7, 12, -2]]
    assert read("simxGetUISlider", "panel", "3") == [9, 3]
    assert read("simxGetObjectPosition", "a", "sim_handle_parent") == [7, -11]
    assert read("simxSetStringSignal", "name", "naïve") == ["name", "naïve".encode()]
    assert read("simxSynchronous", "on") == [True]
    assert read("simxAuxiliaryConsoleOpen", "t", "5", "0", "none", "80,25") == [
        "t", 5, 0, None, [80, 25], None, None,
    ]  # fmt: skip
    with pytest.raises(WrongUse, match="simxLoadScene takes scenePathAndName"):
        read("simxLoadScene")
    assert "3 numbers: 1,2,3" in usage(command_named("simxSetObjectPosition"))
    assert bare(shielded(["-1,2", "-.5", "--at", "-x", " a"])) == ["-1,2", "-.5", "--at", "-x", " a"]


def test_the_calls_that_the_page_shows_can_be_made() -> None:
    page = (Path(__file__).parents[3] / "docs" / "command-line.md").read_text(encoding="utf-8")
    shown = re.findall(r"^    simx (call|watch|image) (.*)", page, re.MULTILINE)
    assert len(shown) >= 8
    for name, line in shown:
        words = shlex.split(line, comments=True)
        if name == "image":
            image.make_parser().parse_args(words)
            continue
        options = parse_words({"call": call, "watch": watch}[name].make_parser(), words)
        parse(command_named(options.function), options.arguments, lambda finder, name: 1)


def test_texts_of_values() -> None:
    assert as_text([0.1 + 0.2, True, [1, 2]]) == "0.3,yes,1,2"
    assert as_text([[1.0, 2.0], [3.0]]) == "1,2;3"
    assert as_text(bytearray(b"\x00\xff")) == "00 ff"
    assert as_text(b"two\nlines") == "two\nlines"


# --- watch ----------------------------------------------------------------------------------------


def test_watch_prints_changes_with_their_time(lab: ServerProcess, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(capsys, "call", "simxSetJointTargetVelocity", "hinge", "1")[0] == 0
    code, lines, _ = run(capsys, "watch", "simxGetJointPosition", "hinge", "--count", 3, "--json")
    assert code == 0
    records = [json.loads(line) for line in lines.splitlines()]
    assert len(records) == 3
    assert records[0]["time"] < records[1]["time"] < records[2]["time"]
    assert len({record["position"] for record in records}) == 3
    assert run(capsys, "call", "simxSetJointTargetVelocity", "hinge", "0")[0] == 0


def test_watch_every_prints_what_has_not_changed(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    code, text, _ = run(capsys, "watch", "simxGetObjectPosition", "arm", "--every", "0.01", "--count", 3)
    assert code == 0
    lines = text.splitlines()
    assert len(lines) == 3
    assert all(re.fullmatch(r"\d+\.\d{3}  0,0,1", line) for line in lines)


def test_watch_is_for_reading_only(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["simxStopSimulation"], ["simxGetVisionSensorImage", "eye"], ["simxReadStringStream", "s"]):
        code, _, error = run(capsys, "watch", *words)
        assert code == 2
        assert "cannot be watched" in error


def test_watch_ends_with_the_reason_when_it_is_refused(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, error = run(capsys, "watch", "simxGetFloatSignal", "nothing")
    assert (code, out) == (1, "")
    assert "nothing" in error


# --- image ----------------------------------------------------------------------------------------


def test_image_is_written_the_right_way_up(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "out.png"
    code, line, _ = run(capsys, "image", "eye", file)
    assert (code, line) == (0, f"{file}: 32x24\n")
    picture = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    assert picture.shape == (24, 32, 3)
    blue, _, red = picture[8, 16]  # OpenCV has blue first
    assert red > blue
    blue, _, red = picture[16, 16]
    assert blue > red


def test_depth_is_grey_of_sixteen_bits(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "depth.png"
    code, text, _ = run(capsys, "image", "eye", file, "--depth", "--json")
    assert code == 0
    assert json.loads(text) == {"file": str(file), "width": 32, "height": 24, "depth": True}
    depths = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
    assert depths is not None
    assert (depths.dtype, depths.shape) == (np.uint16, (24, 32))
    assert 0 < depths[12, 16] < depths[0, 0] == 65535


def test_what_cannot_be_written_or_seen_is_said(
    lab: ServerProcess, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    code, _, error = run(capsys, "image", "eye", tmp_path / "out.jpg")
    assert code == 2
    assert "call it FILE.png" in error
    code, _, error = run(capsys, "image", "eye", tmp_path / "no" / "out.png")
    assert code == 1
    assert "cannot be written: No such file or directory" in error
    code, _, error = run(capsys, "image", "arm", tmp_path / "out.png")
    assert code == 1
    assert "vision sensor" in error


def test_png_is_read_by_others_as_it_was_meant() -> None:
    file = png([b"\xff\0\0\0\xff\0", b"\0\0\xff\x01\x02\x03"], 2, 2, is_colour=True)
    decoded = cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded is not None
    assert decoded[..., ::-1].tolist() == [[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [1, 2, 3]]]
    file = png([samples_16([0.0, 0.5, 2.0])], 3, 1, is_colour=False, bits=16)
    decoded = cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_UNCHANGED)
    assert decoded is not None
    assert decoded.tolist() == [[0, 32768, 65535]]
    with pytest.raises(ValueError, match="1 rows of 3 bytes"):
        png([b"\0"], 1, 1, is_colour=True)
