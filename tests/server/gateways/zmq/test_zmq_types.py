"""Types of the official client for editors and type checkers: current, and what pyright says of programs with them."""

from __future__ import annotations

import ast
import inspect
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from processes import ROOT
from statements import parsed

from simx_server.gateways.zmq.listing import namespace
from simx_server.gateways.zmq.stubs import files
from simx_server.gateways.zmq.stubs.members import OLD_NAME

RIGHT = """
from __future__ import annotations
import asyncio
import math
import numpy as np
from typing import TYPE_CHECKING
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
from coppeliasim_zmqremoteapi_client.asyncio import RemoteAPIClient as AsyncClient
if TYPE_CHECKING:
    from coppeliasim_zmqremoteapi_client.namespaces import Sim

client = RemoteAPIClient("localhost", port=23000)
sim, simIK, simOMPL = client.require("sim"), client.require("simIK"), client.require("simOMPL")

def joints_of(sim: Sim, robot: int) -> list[int]:
    return sim.getObjectsInTree(robot, sim.object_joint_type)

joints = joints_of(sim, sim.getObject("/UR5", {"noError": True}))
sim.setStepping(True)
sim.startSimulation()
for joint, angle in zip(joints, np.zeros(6)):
    sim.setJointTargetPosition(joint, angle)
sim.setJointTargetVelocity(joints[0], np.linalg.norm(np.ones(3)))
sim.setObjectPosition(joints[0], -1, [0, 0, 1])
sim.setObjectPosition(joints[0], np.array([0.0, 0, 1]), sim.handle_world)
x, y, z = sim.getObjectPosition(joints[0])
image, (width, height) = sim.getVisionSensorImg(joints[0])
pixels = np.frombuffer(image, np.uint8).reshape(height, width, 3)
result, distance, point, found, normal = sim.readProximitySensor(joints[0])
while sim.getSimulationState() != sim.simulation_stopped and sim.getSimulationTime() < 3:
    sim.step()
environment = simIK.createEnvironment()
group = simIK.createGroup(environment)
simIK.setGroupCalculation(environment, group, simIK.method_damped_least_squares, 0.1, 50)

def seen(data: dict[str, object]) -> None: ...

sim.moveToConfig({"joints": joints, "targetPos": [0.0] * 6, "maxVel": [1.0] * 6, "callback": seen})
task = simOMPL.createTask("task")
simOMPL.setAlgorithm(task, simOMPL.Algorithm.RRTConnect)
mass: float = sim.getFloatProperty(joints[0], "mass")
print(math.degrees(sim.getJointPosition(joints[0])), sim.wait(0.1) + mass, sim.packTable([1, "a"]))
print(sim.packDoubleTable([1, 2.5], start=1))
assert client.require("sim-2").getObject("/UR5").position is not None

async def main() -> None:
    async with AsyncClient() as client:
        sim = await client.require("sim")
        joint = await sim.getObject("/UR5/joint")
        print(math.degrees(await sim.getJointPosition(joint)), sim.handle_world + 1)

asyncio.run(main())
"""

WRONG = """
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
from coppeliasim_zmqremoteapi_client.asyncio import RemoteAPIClient as AsyncClient
client = RemoteAPIClient()
sim = client.require("sim")
sim.getObjct("/UR5")  # wrong
sim.getObject()  # wrong
sim.getObject(5)  # wrong
sim.setJointTargetPosition("/joint", 0.5)  # wrong
sim.setJointTargetPosition(7, [0.5])  # wrong
sim.setObjectPosition(7, -1, 0.5)  # wrong
sim.getObject(path="/UR5")  # wrong
image, size, more = sim.getVisionSensorImg(7)  # wrong
handle, distance = sim.readProximitySensor(7)  # wrong
sim.getJointPosition(7).value  # wrong
sim.handle_wrold  # wrong
sim.handle_world = 3  # wrong
client.require("simik")  # wrong
client.require("simOMPL").Algorithm.RTT  # wrong

async def main(client: AsyncClient) -> float:
    sim = await client.require("sim")
    await sim.getObjct("/UR5")  # wrong
    print(sim.handle_wrold)  # wrong
    return sim.getJointPosition(7)  # wrong
"""

SCRIPT = """
def sysCall_init():
    sim = require("sim")
    simIK = require("simIK")
    sim.getObject("..").name  # wrong
    simIK.createEnvironment(1, 2, 3)  # wrong

def sysCall_sensing():
    sim.getSimulationTime()
    sim.getSimulationTme()  # wrong
    require("simik")  # wrong
"""


@pytest.fixture(scope="module")
def complaints(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[int]]:
    """The lines of which pyright complains, by file: those of three programs and of the stubs themselves."""
    for package in ("pyright", "coppeliasim_zmqremoteapi_client"):
        pytest.importorskip(package)
    folder = tmp_path_factory.mktemp("typed")
    shutil.copytree(files.FOLDER / files.PACKAGE, folder / "typings" / files.PACKAGE.removesuffix("-stubs"))
    shutil.copy(files.FOLDER / "scripts" / "__builtins__.pyi", folder)
    for name, text in {"right": RIGHT, "wrong": WRONG, "script": SCRIPT}.items():
        (folder / f"{name}.py").write_text(text, encoding="utf-8")
    (folder / "pyrightconfig.json").write_text("{}", encoding="utf-8")
    command = [
        sys.executable,
        "-m",
        "pyright",
        "--outputjson",
        "--pythonpath",
        sys.executable,
        "-p",
        str(folder),
    ]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100)
    if not done.stdout.startswith("{"):
        pytest.skip(f"pyright does not run here: {done.stderr.strip()[-200:]}")
    report: dict[str, Any] = json.loads(done.stdout)
    assert report["summary"]["filesAnalyzed"] >= 8
    found: dict[str, set[int]] = {}
    for each in report["generalDiagnostics"]:
        if each["severity"] == "error":
            found.setdefault(Path(each["file"]).name, set()).add(each["range"]["start"]["line"] + 1)
    return found


def marked(text: str) -> set[int]:
    return {number for number, line in enumerate(text.splitlines(), 1) if line.endswith("# wrong")}


def test_the_stubs_are_those_of_the_tables() -> None:
    for name, text in files.files().items():
        stale = f"{name} is stale; run: python -m simx_server.gateways.zmq.stubs"
        assert (files.FOLDER / name).read_text(encoding="utf-8") == text, stale


def test_a_right_program_and_the_stubs_have_no_errors(complaints: dict[str, set[int]]) -> None:
    assert {name: lines for name, lines in complaints.items() if name not in ("wrong.py", "script.py")} == {}


def test_each_mistake_of_a_program_is_found(complaints: dict[str, set[int]]) -> None:
    assert complaints["wrong.py"] == marked(WRONG)


def test_the_mistakes_of_a_scenes_script_are_found(complaints: dict[str, set[int]]) -> None:
    assert complaints["script.py"] == marked(SCRIPT)


def classes(name: str) -> dict[str, ast.ClassDef]:
    tree = parsed(files.FOLDER / files.PACKAGE / name)
    return {each.name: each for each in tree.body if isinstance(each, ast.ClassDef)}


def test_each_member_that_a_client_gets_is_in_the_class_of_its_namespace() -> None:
    found = classes("namespaces.pyi")
    functions = {each.name for each in found["Sim"].body if isinstance(each, ast.FunctionDef)}
    constants = {
        ast.unparse(each.target) for each in found["SimConstants"].body if isinstance(each, ast.AnnAssign)
    }
    old = {name for name in namespace("sim") if OLD_NAME.match(name)}
    assert {"extROS_enablePublisher", "extRemoteApiStart"} <= old
    own_of_the_client = {"getScriptFunctions"}
    assert functions | constants | {"yield"} | old == set(namespace("sim")) | own_of_the_client
    assert not functions & old


def test_awaited_calls_have_the_constants_of_the_others() -> None:
    found = classes("asyncio/namespaces.pyi")
    for name, each in classes("namespaces.pyi").items():
        if name in found:
            inherited = [f"constants.{ast.unparse(base)}" for base in each.bases]
            assert [ast.unparse(base) for base in found[name].bases] == inherited


@pytest.mark.parametrize("module", ["", ".asyncio"])
def test_the_class_of_the_client_has_the_parameters_of_the_real_one(module: str) -> None:
    real = pytest.importorskip(f"coppeliasim_zmqremoteapi_client{module}").RemoteAPIClient
    stub = classes(f"{module.replace('.', '')}/__init__.pyi".lstrip("/"))["RemoteAPIClient"]
    for each in stub.body:
        if isinstance(each, (ast.FunctionDef, ast.AsyncFunctionDef)) and not each.decorator_list:
            arguments = [
                a.arg for a in [*each.args.args, *each.args.kwonlyargs, *filter(None, [each.args.vararg])]
            ]
            function = getattr(real, each.name)
            assert list(inspect.signature(function).parameters) == arguments
            assert inspect.iscoroutinefunction(function) == isinstance(each, ast.AsyncFunctionDef)


def test_the_project_of_the_stubs_contains_their_package() -> None:
    text = (ROOT / "packages" / "types" / "pyproject.toml").read_text(encoding="utf-8")
    assert f'packages = ["{files.PACKAGE}"]' in text
