"""A script that misbehaves harms itself alone: others are answered all the while."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest
from idiom_world import PORTS
from loopback import LoopbackTransport
from real_world import RealWorld, handle_of
from scripted_world import said, scripted

import simx_client as vrep
from simx_client.connection.clients import CLIENTS
from simx_client.connection.connection import Connection
from simx_client.protocol.codec import decode_delivery, encode
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Batch, Call
from simx_server.scripting import script
from simx_server.service.calls.work import BatchWork

pytestmark = pytest.mark.slow

pytest.importorskip("lupa")
BLOCKING = vrep.simx_opmode_blocking

TIMEOUT = 60.0
"""Seconds that a client waits: a busy machine stretches the second of processor time that a script has."""

SCENE = """
<mujoco>
  <worldbody>
    <body name="bad"><geom size="0.05"/></body>
    <body name="good" pos="1 0 0"><geom size="0.05"/>
      <body name="arm"><joint name="hinge"/><geom size="0.05" pos="0.1 0 0"/></body></body>
  </worldbody>
  <custom>
    <text name="simx:script:bad" data="file=bad.lua"/>
    <text name="simx:lua:good" data="
      function sysCall_actuation()
          sim.setIntegerSignal('passes', 1 + (sim.getIntegerSignal('passes') or 0))
      end"/>
  </custom>
</mujoco>
"""


class ThreadedWorld(RealWorld):
    """The server loop runs in a thread; each client is a separate caller."""

    def __init__(self, scene: Path) -> None:
        super().__init__(scene)
        self._thread = threading.Thread(target=self.loop.run)
        self._thread.start()

    def client(self, port: int = PORTS[0]) -> int:
        transport = LoopbackTransport(self.loop, port=port, turns=False)
        connection = Connection(lambda: transport, where=transport.client, timeout=TIMEOUT)
        client_id = CLIENTS.add(connection)
        connection.connect(1.0)
        return client_id

    def close(self) -> None:
        vrep.simxFinish(-1)
        self.loop.service.ending.request()
        self._thread.join(20)
        super().close()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "scene.xml").write_text(SCENE, encoding="utf-8")
    return tmp_path


@pytest.fixture
def worlds() -> Iterator[list[RealWorld]]:
    opened: list[RealWorld] = []
    yield opened
    for world in opened:
        world.close()


def begin(worlds: list[RealWorld], folder: Path, script: str, limit: float = 1.0) -> ThreadedWorld:
    (folder / "bad.lua").write_text(script, encoding="utf-8")
    world = ThreadedWorld(folder / "scene.xml")
    worlds.append(world)
    world.parts.scripts.time_limit = limit
    return world


ANSWER = "function answer() return {7}, {}, {}, '' end"

MISBEHAVIOUR = {
    "endless loop": "while true do end",
    "errors swallowed for ever": "while true do pcall(error) end",
    "stop swallowed for ever": "while true do pcall(function() while true do end end) end",
    "coroutines": "while true do coroutine.wrap(function() for i = 1, 100 do end end)() end",
    "calls of sim": "while true do sim.getSimulationTime() end",
    "pattern": "string.find(string.rep('a', 5000), string.rep('a*', 20) .. 'b')",
    "patterns for ever": "while true do pcall(string.match, string.rep('a', 30000), '.-.-b') end",
    "replacement": "string.gsub(string.rep('a', 100000), '(a*)*b', 'x') while true do end",
    "sorting": "while true do local t = {} for i = 1, 1e6 do t[i] = -i end table.sort(t) end",
    "compilation": "while true do load(string.rep('x = 1 ', 30000)) end",
    "memory": "while true do pcall(function() local s = 'x' while true do s = s .. s end end) end",
    "long texts": "local s = string.rep('a', 9e6) while true do local t = s .. 'b' end",
    "tables": "while true do pcall(function() local t = {} while true do t[#t + 1] = {} end end) end",
    "moving": "table.move({}, 1, 1e15, 2)",
    "inserting": "table.insert(setmetatable({}, {__len = function() return 1e15 end}), 1, 2)",
    "nothing repeated": "while true do string.rep('', 1e15) end",
    "closing": """local made = coroutine.create(function()
        local last <close> = setmetatable({}, {__close = function() while true do end end})
        while true do end
    end)
    while true do coroutine.resume(made) coroutine.close(made) end""",
    "comparing in C": """local function length() return 1e9 end
    table.sort(setmetatable({}, {__len = length, __index = rawlen, __newindex = rawequal}), math.ult)""",
    "upper case": "local s = string.rep('a', 15e6) while true do string.upper(s) end",
    "concatenation": "while true do local t = {} for i = 1, 1e6 do t[i] = i end table.concat(t, ',') end",
}


@pytest.mark.parametrize("body", MISBEHAVIOUR.values(), ids=MISBEHAVIOUR)
def test_others_are_answered_while_a_script_runs_on(worlds: list[RealWorld], folder: Path, body: str) -> None:
    """The caller of the script waits; another client gets twenty answers a second and more.

    The seconds are the processor's, as those of the script's limit are: on a busy machine both take longer.
    """
    limit = 0.1
    world = begin(worlds, folder, f"function hang() {body} end\n{ANSWER}", limit)
    caller, other = world.client(), world.client()
    assert vrep.simxStartSimulation(caller, BLOCKING) == 0
    asking = Asking(world, handle_of(other, "hinge"))
    assert call(caller, "hang")[0] == 8
    assert asking.answered >= limit / 0.05
    assert call(other, "answer")[:2] == (0, [7])


class Asking:
    """A client that always has a question for the server when a script lets others be served."""

    def __init__(self, world: ThreadedWorld, joint: int) -> None:
        self._loop = world.loop
        self._link = LoopbackTransport(world.loop, turns=False)
        self._link.greet(1.0)
        self._question = encode(Batch(0, 0, [Call(1, 0, 0, "simxGetJointPosition", [joint])]))
        self.answered = 0
        world.simulation.interruptions.serve_others = self._serve

    def _serve(self) -> None:
        self._loop.service.queue.submit(self._link.client, BatchWork(self._question))
        self._loop.service.meanwhile.serve_others()
        while (answer := self._link.receive(0)) is not None:
            assert decode_delivery(answer).replies[0].status == 0
            self.answered += 1


def call(client: int, function: str) -> tuple[int, list[int], list[float], list[str], bytearray]:
    return vrep.simxCallScriptFunction(client, "bad", 1, function, [], [], [], bytearray(), BLOCKING)


def test_what_interferes_waits_and_keeps_its_order(worlds: list[RealWorld], folder: Path) -> None:
    """Removing an object while a script runs happens after it; so does what the same client sends then."""
    world = begin(
        worlds,
        folder,
        f"""{ANSWER}
        function hang()
            sim.setIntegerSignal('began', 1)
            while not sim.getIntegerSignal('go') do end
            return {{sim.getObjectHandle('good')}}, {{}}, {{}}, ''
        end""",
        limit=20.0,
    )
    caller, editor, other = world.client(), world.client(), world.client()
    assert vrep.simxStartSimulation(caller, BLOCKING) == 0
    good = handle_of(editor, "good")
    outcome: list[object] = []
    hanging = threading.Thread(target=lambda: outcome.append(call(caller, "hang")))
    hanging.start()
    while vrep.simxGetIntegerSignal(other, "began", BLOCKING)[0]:
        pass
    vrep.simxRemoveObject(editor, good, vrep.simx_opmode_oneshot)
    vrep.simxSetIntegerSignal(editor, "later", 1, vrep.simx_opmode_oneshot)
    for _ in range(3):
        assert vrep.simxGetObjectPosition(other, good, -1, BLOCKING)[0] == 0
        assert vrep.simxGetIntegerSignal(other, "later", BLOCKING)[0] != 0
    assert vrep.simxSetIntegerSignal(other, "go", 1, BLOCKING) == 0
    hanging.join()
    assert outcome[0][:2] == (0, [good])  # type: ignore[index]
    assert vrep.simxGetIntegerSignal(editor, "later", BLOCKING) == (0, 1)
    assert vrep.simxGetObjectPosition(other, good, -1, BLOCKING)[0] == 8


def test_a_stop_ends_a_plan_that_a_script_makes(worlds: list[RealWorld], folder: Path) -> None:
    world = begin(
        worlds,
        folder,
        """
        function sysCall_actuation()
            local hinge = sim.getObjectHandle('hinge')
            local task = simOMPL.createTask('none')
            local space = simOMPL.createStateSpace('j', simOMPL.StateSpaceType.joint_position, hinge, {-1}, {1}, 1)
            simOMPL.setStateSpace(task, {space})
            simOMPL.setStateValidationCallback(task, function(state) return math.abs(state[1]) > 0.5 end)
            simOMPL.setStartState(task, {-1})
            simOMPL.setGoalState(task, {1})
            sim.setIntegerSignal('began', 1)
            print(simOMPL.solve(task, 60))
        end""",
    )
    planner, stopper = world.client(), world.client()
    assert vrep.simxStartSimulation(planner, BLOCKING) == 0
    while vrep.simxGetIntegerSignal(stopper, "began", BLOCKING)[0]:
        pass
    assert vrep.simxStopSimulation(stopper, BLOCKING) == 0  # the plan takes as long as this waits
    assert world.parts.status_bar.messages[-1].endswith("false")


def test_commands_that_run_scripts_step_or_edit_wait_for_scripts_and_readers_do_not() -> None:
    waiting = {command.name for command in ANSWERED.values() if command.waits_for_scripts}
    assert not [name for name in waiting if ANSWERED[name].only_reads]
    words = (
        "Load",
        "Remove",
        "Create",
        "CopyPaste",
        "Start",
        "Stop",
        "Pause",
        "Synchronous",
        "CallScript",
        "Parent",
    )
    editing = {
        c.name for c in ANSWERED.values() if any(word in c.name for word in words) and not c.only_reads
    }
    assert editing <= waiting


def test_a_script_that_hangs_in_a_pass_is_stopped_and_the_others_go_on(
    worlds: list[RealWorld], folder: Path
) -> None:
    world = begin(worlds, folder, "function sysCall_actuation() while true do pcall(error) end end", 0.1)
    client = world.client()
    assert vrep.simxSynchronous(client, True) == 0
    assert vrep.simxStartSimulation(client, BLOCKING) == 0
    for _ in range(3):
        assert vrep.simxSynchronousTrigger(client) == 0
    assert vrep.simxGetIntegerSignal(client, "passes", BLOCKING) == (0, 3)
    assert call(client, "answer")[0] == 8
    assert "stopped by an error: bad.lua:1: took too long" in "".join(
        vrep.simxGetLastErrors(client, BLOCKING)[1]
    )


def test_a_long_text_is_looked_for_only_up_to_a_bound(worlds: list[RealWorld], folder: Path) -> None:
    script = "function f() string.find(string.rep('a', 8e6), string.rep('a', 4e6) .. 'b', 1, true) end"
    world = begin(worlds, folder, script)
    client = world.client()
    assert vrep.simxStartSimulation(client, BLOCKING) == 0
    assert call(client, "f")[0] == 8
    assert "too long to be looked for" in "".join(vrep.simxGetLastErrors(client, BLOCKING)[1])


def test_every_client_is_told_of_an_error_of_a_script(worlds: list[RealWorld], folder: Path) -> None:
    world = begin(worlds, folder, "function sysCall_actuation() sim.getObjectPostion(1, -1) end")
    first, second = world.client(), world.client()
    assert vrep.simxSynchronous(first, True) == 0
    assert vrep.simxStartSimulation(first, BLOCKING) == 0
    assert vrep.simxSynchronousTrigger(first) == 0
    for client in (first, second):
        (told,) = vrep.simxGetLastErrors(client, BLOCKING)[1]
        assert told.startswith("child script of 'bad' (bad.lua) is stopped: bad.lua:1: sim.getObjectPostion")
        assert vrep.simxGetLastErrors(client, BLOCKING)[1] == []


def test_an_endless_loop_of_edits_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    """Edits do not count against a script's time, so here, where each takes long, the loop would go on for ever."""
    monkeypatch.setattr(script, "EDITING_LIMIT", 0.1)
    monkeypatch.setattr(script, "time", SimpleNamespace(thread_time=count(step=30).__next__))
    world = scripted({"lua:base": "while true do sim.removeObject(sim.createDummy(0.1)) end"})
    said(world)
    world.parts.scripts.time_limit = 0.1
    world.run(0)
    world.parts.scripts.close()
    assert "took too long" in said(world)[-1]
