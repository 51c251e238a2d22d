"""``simx-check`` on wrappers: what is called counts, not what it is called like."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked_programs import START, check, objects_of, texts_of, write

OWN = """
import vrep

class Robot:
    def __init__(self, name, port=19997):
        self.name = name
        self.client = vrep.simxStart('127.0.0.1', port, True, True, 5000, 5)

    def simxStart(self):
        return vrep.simxStartSimulation(self.client, vrep.simx_opmode_blocking)

    def simxGetHandle(self, suffix):
        return vrep.simxGetObjectHandle(self.client, self.name + suffix, vrep.simx_opmode_blocking)

    def simxGetObjectHandle(self, suffix):
        return self.simxGetHandle(suffix)[1]

robot = Robot('UR5')
robot.simxStart()
robot.simxGetObjectHandle('_joint1')
robot.simxGetHandle('_tip')
"""


def test_a_wrappers_methods_that_have_our_names_are_no_problems_and_are_followed(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": OWN})
    code, record = check(tmp_path / "script.py")
    assert (code, texts_of(record)) == (0, [])
    assert set(record["functions"]) == {"simxStart", "simxStartSimulation", "simxGetObjectHandle"}
    assert objects_of(record) == ["UR5_joint1", "UR5_tip"]
    assert record["ports"] == [19997]


@pytest.mark.parametrize(
    "text",
    [
        "api = vrep\nf = api.simxGetObjectHandle\nf(c, 'it', B)",
        "from vrep import simxGetObjectHandle as handle\nhandle(c, 'it', B)",
        "from vrep import *\nsimxGetObjectHandle(c, 'it', simx_opmode_blocking)",
        "getattr(vrep, 'simxGetObjectHandle')(c, 'it', B)",
        "import importlib\nimportlib.import_module('vrep').simxGetObjectHandle(c, 'it', B)",
        "class R:\n  def __init__(self): self.sim = vrep\n  def go(self): self.sim.simxGetObjectHandle(c, 'it', B)",
        "class R:\n  sim = vrep\n  def go(self): self.sim.simxGetObjectHandle(c, 'it', B)",
        "class R:\n  def __getattr__(self, n): return getattr(vrep, n)\nR().simxGetObjectHandle(c, 'it', B)",
        "class R:\n  @property\n  def api(self): return vrep\n  def go(self): self.api.simxGetObjectHandle(c, 'it', B)",
        "def go(sim): sim.simxGetObjectHandle(c, 'it', B)\ngo(vrep)",
        "def run(f, *rest): f(c, 'it', B)\nrun(vrep.simxGetObjectHandle)",
        "def api():\n  global s\n  s = vrep\ndef go(): s.simxGetObjectHandle(c, 'it', B)",
        "try:\n  import sim as v\nexcept ImportError:\n  import vrep as v\nv.simxGetObjectHandle(c, 'it', B)",
        "for f in [vrep.simxGetObjectHandle]: f(c, 'it', B)",
        "calls = {'handle': vrep.simxGetObjectHandle}\ncalls['handle'](c, 'it', B)",
        "def go(unknown): unknown.simxGetObjectHandle(c, 'it', B)",
        "import simx_client as v\nv.simxGetObjectHandle(c, 'it', B)",
        "def go(name, *rest): getattr(vrep, name)(c, 'it', B)\ngo('simxGetObjectHandle')",
        "for n in ('simxGetObjectHandle',): getattr(vrep, n)(c, 'it', B)",
    ],
)
def test_the_binding_is_followed_under_other_names(tmp_path: Path, text: str) -> None:
    write(tmp_path, {"script.py": f"import vrep\n{START}{text}\n"})
    code, record = check(tmp_path / "script.py")
    assert (code, texts_of(record), objects_of(record)) == (0, [], ["it"])


@pytest.mark.parametrize(
    "text",
    [
        "class R:\n  def simxStart(self, port): pass\nR().simxStart(3)",
        "class Base:\n  def simxStart(self, port): pass\nclass R(Base): pass\nself = R()\nself.simxStart(3)",
        "import elsewhere\nclass R(elsewhere.Base):\n  def go(self): self.simxGetHandle('a'); self.simxGetPose()",
        "import elsewhere\nrobot = elsewhere.Robot()\nrobot.simxStart(3); robot.simxGetPose()",
        "def simxMove(a, b): pass\nsimxMove(1, 2)",
        "def go(robot): robot.simxGetEverything()",
        "def go(robot): robot.simxGetObjectPosition('name')",
    ],
)
def test_what_is_not_the_bindings_is_no_problem(tmp_path: Path, text: str) -> None:
    write(tmp_path, {"script.py": f"import vrep\n{START}{text}\n"})
    code, record = check(tmp_path / "script.py")
    assert (code, texts_of(record)) == (0, [])


def test_a_wrapper_with_our_name_does_not_hide_a_wrong_call_in_it(tmp_path: Path) -> None:
    text = "class R:\n  def simxGetPing(self): return vrep.simxGetPing(c)\nR().simxGetPing()\n"
    write(tmp_path, {"script.py": f"import vrep\n{START}{text}"})
    code, record = check(tmp_path / "script.py")
    assert (code, record["unknown_functions"]) == (1, ["simxGetPing"])


def test_a_function_that_is_imported_and_not_there_is_a_problem(tmp_path: Path) -> None:
    write(
        tmp_path,
        {"script.py": f"import vrep\nfrom vrep import simxGetPosition, sim_object_joint_type\n{START}"},
    )
    code, record = check(tmp_path / "script.py")
    assert code == 1
    assert [text.partition(";")[0] for text in texts_of(record)] == [
        "there is no function simxGetPosition in the remote API"
    ]


def test_a_class_by_another_name_gets_its_arguments(tmp_path: Path) -> None:
    robot = f"import vrep\n{START}class Arm:\n  def __init__(self, n): vrep.simxGetObjectHandle(c, n + '_tip', B)\n"
    own = "import robot\nfrom robot import Arm as A\nRobot = robot.Arm\nRobot('left')\nA('right')\n"
    own += "class Mine(robot.Arm): pass\nMine('third')\nclass Yours(robot.Arm):\n"
    own += "  def __init__(self): super().__init__('fourth')\n"
    own += "class Old(A):\n  def __init__(self): A.__init__(self, 'fifth')\n"
    write(tmp_path, {"script.py": own, "robot.py": robot})
    _, record = check(tmp_path / "script.py")
    assert objects_of(record) == [f"{each}_tip" for each in ("fifth", "fourth", "left", "right", "third")]


def test_names_of_another_module_are_followed(tmp_path: Path) -> None:
    own = f"import vrep, config\nfrom config import TIP\nfrom more import *\n{START}"
    own += "for n in (config.BASE, TIP, LAST): vrep.simxGetObjectHandle(c, n, B)\n"
    write(
        tmp_path,
        {"script.py": own, "config.py": "BASE = 'base'\nTIP = 'tip'\n", "more.py": "LAST = 'last'\n"},
    )
    _, record = check(tmp_path / "script.py")
    assert objects_of(record) == ["base", "last", "tip"]


def test_a_wrapper_that_gives_the_client_itself_is_read_by_its_count_of_arguments(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": "def go(robot, mode):\n  robot.simxGetObjectHandle('it', mode)\n"})
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record)) == (0, ["it"])


BOUND = """
import types
import vrep

class Modes:
    blocking = vrep.simx_opmode_blocking

class Simulator:
    def __init__(self, port):
        self.client = -1
        for name in dir(vrep):
            if isinstance(getattr(vrep, name), types.FunctionType):
                self.bind(name)
        self.client = self.simxStart('127.0.0.1', port, waitUntilConnected=True,
            doNotReconnectOnceDisconnected=True, timeOutInMs=1000, commThreadCycleInMs=0)
    def bind(self, name):
        function = getattr(vrep, name)
        setattr(self, name, lambda *args: function(self.client, *args))
    def __enter__(self):
        return self
    def handle(self, name):
        return self.simxGetObjectHandle(name, Modes.blocking)

class Strict:
    def __init__(self, client): self.client = client
    def __getattr__(self, name):
        function = getattr(vrep, name)
        def inner(*args): return function(self.client, *args)[1]
        return inner
    def close(self): vrep.simxFinish(self.client)

class Opened:
    def __enter__(self): return Strict(0)

class Car:
    def __init__(self, api, name='Car'):
        self.api = api
        self.api.simxGetObjectHandle(name, vrep.simx_opmode_blocking)
        self.api.simxCallScriptFunction(name, 1, 'drive', [], [], [], b'', vrep.simx_opmode_blocking)

with Simulator(20000) as simulator:
    simulator.handle('base')
with Opened() as api:
    Car(api)
    api.simxSetFloatSignal('speed', 1, vrep.simx_opmode_oneshot)
    api.close()
"""


def test_wrappers_that_bind_every_function_are_read_with_the_client_that_they_add(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": BOUND})
    code, record = check(tmp_path / "script.py")
    assert (code, texts_of(record)) == (0, [])
    assert (objects_of(record), record["ports"]) == (["Car", "base"], [20000])
    assert [(each["object"], each["function"]) for each in record["script_functions"]] == [("Car", "drive")]
    assert [each["name"] for each in record["signals"]] == ["speed"]
    assert "close" not in record["functions"]


def test_client_objects_of_this_project_are_understood(tmp_path: Path) -> None:
    text = """
        from simx_client import Client
        with Client('127.0.0.1', 19997) as client:
            arm = client.joints(*[f'UR5_joint{i}' for i in range(6)])
            client.camera('eye').rgb()
            client.jiont('a')
        """
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py")
    assert (code, objects_of(record)) == (1, ["UR5_joint*", "eye"])
    assert texts_of(record) == ["simx_client.Client has no jiont; did you mean 'joint' or 'joints'?"]


def test_a_method_of_the_program_is_meant_where_the_object_is_not_known(tmp_path: Path) -> None:
    text = "class R:\n  def simxPauseSimulation(self): pass\ndef go(robot): robot.simxPauseSimulation()\n"
    write(tmp_path, {"script.py": f"import vrep\n{START}{text}"})
    assert list(check(tmp_path / "script.py")[1]["functions"]) == ["simxStart"]


def test_what_a_with_block_gives_is_what_is_entered(tmp_path: Path) -> None:
    text = (
        "class Opened:\n  def __enter__(self): return vrep\nwith Opened() as v: v.simxGetObjectPositon(c)\n"
    )
    write(tmp_path, {"script.py": f"import vrep\n{START}{text}"})
    code, record = check(tmp_path / "script.py")
    assert (code, record["unknown_functions"]) == (1, ["simxGetObjectPositon"])
