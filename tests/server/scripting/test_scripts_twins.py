"""Python scripts in the whole server core: not a digit of what they do may differ from their twins in Lua."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from handler_calls import World

from simx_server.errors import CommandError

pytest.importorskip("lupa")
pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(sys.platform != "linux", reason="Python scripts run on Linux only"),
]

HERE = Path(__file__).parent
SCRIPTS = HERE / "scripts"
ROOT = HERE.parents[2]
MODELS = ROOT / "scenes" / "models"
SEED = ROOT.parent / "shared" / "seed"

SCENE = """
<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body name="RG2"><geom size="0.05"/>
      <body name="finger" pos="0 0 0.2">
        <joint name="RG2_openCloseJoint" type="slide" axis="1 0 0" range="-0.1 0.1" limited="true"/>
        <geom size="0.02" mass="0.1"/>
      </body>
    </body>
    <body name="plain" pos="2 0 0"><freejoint/><geom type="box" size="0.05 0.06 0.07" mass="1"/></body>
  </worldbody>
  <custom>
    <text name="simx:joint:RG2_openCloseJoint" data="mode=force motor=on control=velocity lock=on max_force=50"/>
    <text name="simx:script:RG2" data="file={file}"/>
  </custom>
</mujoco>
"""

Visitor = Callable[[World, int], Any]


def trace_of(folder: Path, script: Path, passes: int, visit: Visitor) -> list[Any]:
    """The state that is visible from outside: poses after each step, results of the visitor's calls, all messages."""
    (folder / script.name).write_bytes(script.read_bytes())
    (folder / "scene.xml").write_text(SCENE.format(file=script.name), encoding="utf-8")
    world = World(file=folder / "scene.xml")
    motor, plain = world.handle("RG2_openCloseJoint"), world.handle("plain")
    trace: list[Any] = []
    world.run(0)
    for number in range(passes):
        trace.append(visit(world, number))
        world.parts.step()
        trace.append(world.call("simxGetJointPosition", motor))
        trace.append(world.call("simxGetJointMaxForce", motor))
        trace.append(world.call("simxGetObjectPosition", plain, -1))
        trace.append(world.call("simxGetObjectOrientation", plain, -1))
    world.call("simxStopSimulation")
    trace += [message.replace(script.name, "script") for message in world.parts.status_bar.messages]
    assert not [message for message in world.parts.status_bar.messages if "is stopped:" in message]
    return trace


def call(world: World, function: str, *inputs: Any) -> Any:
    return world.call("simxCallScriptFunction", "RG2", 1, function, *(inputs or ([], [], [], b"")))


def open_and_close(world: World, number: int) -> Any:
    names = {3: "rg2Close", 8: "rg2Open", 9: "rg2Close"}
    if number == 11:
        world.call("simxSetIntegerSignal", "RG2_open", 1)
    return call(world, names[number]) if number in names else None


def watch_ready(world: World, _number: int) -> Any:
    return world.parts.signals.get_integer("ready")


def command(world: World, number: int) -> Any:
    signals = world.parts.signals
    orders = {1: b"o", 3: b"p", 4: b"qm", 5: b"m?m", 7: b"cp", 9: b"q"}
    if number in orders:
        world.call("simxSetStringSignal", "commands", orders[number])
    answer = call(
        world, "answer", [1, 2, number], [0.5, number / 3], ["a", "gr\xfc\xdfe"], bytes([number, 200])
    )
    values = [
        signals.get_integer("served"),
        signals.get_float("unpacked"),
        signals.get_string("packed"),
        signals.get_string("commands"),
    ]
    return answer, values


def pause_once(world: World, number: int) -> Any:
    if number == 4:
        world.call("simxPauseSimulation")
        world.call("simxStartSimulation")


TWINS: dict[str, tuple[Path, Path, int, Visitor]] = {
    "gripper": (MODELS / "rg2.lua", SCRIPTS / "rg2.py", 15, open_and_close),
    "the tutorial's gripper": (SEED / "rg2.lua", SCRIPTS / "rg2_seed.py", 15, open_and_close),
    "threaded": (SCRIPTS / "threaded.lua", SCRIPTS / "threaded.py", 30, watch_ready),
    "signals": (SCRIPTS / "signals.lua", SCRIPTS / "signals.py", 12, command),
    "call-backs": (SCRIPTS / "callbacks.lua", SCRIPTS / "callbacks.py", 10, pause_once),
}


@pytest.mark.parametrize(("lua", "python", "passes", "visit"), TWINS.values(), ids=TWINS)
def test_twins_do_the_same(tmp_path: Path, lua: Path, python: Path, passes: int, visit: Visitor) -> None:
    if lua.parent == SEED and not lua.is_file():
        pytest.skip("the tutorial's script lies beside the repository only")
    traces: list[list[Any]] = []
    for script in (lua, python):
        folder = tmp_path / script.suffix[1:]
        folder.mkdir()
        traces.append(trace_of(folder, script, passes, visit))
    assert traces[0] == traces[1]
    assert len({repr(item) for item in traces[0]}) > passes, "something must have happened"


def python_world(folder: Path, source: str) -> World:
    (folder / "mine.py").write_text(source, encoding="utf-8")
    (folder / "scene.xml").write_text(SCENE.format(file="mine.py"), encoding="utf-8")
    return World(file=folder / "scene.xml")


def test_endless_script_ends_alone_and_begins_again_at_the_next_start(tmp_path: Path) -> None:
    world = python_world(tmp_path, "def sysCall_actuation():\n    while True:\n        pass\ndef f(*a): pass")
    world.parts.scripts.time_limit = 0.1
    for _ in range(2):
        world.run(3)
        assert re.search(
            r"mine\.py(:[23])?: took too long and was stopped", world.parts.status_bar.messages[-1]
        )
        with pytest.raises(CommandError, match=r"was stopped by an error: .*took too long"):
            call(world, "f")
        world.call("simxStopSimulation")
    assert world.parts.status_bar.count == 2


def test_script_killed_in_a_clients_call_is_told_in_the_next_step(tmp_path: Path) -> None:
    world = python_world(tmp_path, "import os\ndef f(*a): os._exit(4)\ndef sysCall_sensing(): pass")
    world.run(1)
    with pytest.raises(CommandError, match=r"mine\.py: its process ended by itself \(exit code 4\)"):
        call(world, "f")
    assert world.parts.status_bar.count == 0
    world.parts.step()
    assert "is stopped: mine.py: its process ended by itself" in world.parts.status_bar.messages[-1]
    world.call("simxStopSimulation")


def test_script_finds_modules_and_data_beside_the_scene(tmp_path: Path) -> None:
    (tmp_path / "gains.txt").write_text("2 3", encoding="utf-8")
    (tmp_path / "tools").mkdir()
    (tmp_path / "helper.py").write_text("def product(a, b):\n    return a * b\n", encoding="utf-8")
    world = python_world(
        tmp_path,
        "from helper import product\n"
        "def f(*a):\n    return [product(*map(int, open('gains.txt').read().split()))], [], [__file__], ''\n",
    )
    world.run(1)
    assert call(world, "f") == ([6], [], ["mine.py"], b"")
    world.call("simxStopSimulation")


def test_text_within_the_scene_may_be_indented_and_its_lines_are_counted(tmp_path: Path) -> None:
    text = """
        def f(*a):
            return [sim.getObjectHandle('plain')], [], [], ''
        def g(*a):
            return 1 / 0
    """
    xml = SCENE.replace('simx:script:RG2" data="file={file}"', f'simx:python:RG2" data="{text}"')
    world = World(xml)
    world.run(1)
    assert call(world, "f") == ([world.handle("plain")], [], [], b"")
    with pytest.raises(CommandError, match=r"RG2\.py:5: ZeroDivisionError"):
        call(world, "g")
    world.call("simxStopSimulation")
