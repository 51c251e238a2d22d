"""``simx-check`` on programs of CoppeliaSim's ZeroMQ remote API."""

from __future__ import annotations

from pathlib import Path

import pytest
from checked_programs import START, check, objects_of, page_of, texts_of, write

PROGRAM = """
from {module} import RemoteAPIClient
client = RemoteAPIClient()
sim = client.{get}('sim')
class Robot:
    def __init__(self, sim, name):
        self.sim, self.handle = sim, sim.getObject(name)
    def go(self):
        self.sim.setJointTargetPosition(self.handle, 1)
        self.sim.moveToConfig({{}})
Robot(sim, '/UR5')
sim.startSimulation()
client.setStepping(True)
print(sim.handle_world)
"""

CLIENTS = ("coppeliasim_zmqremoteapi_client", "zmqRemoteApi")


@pytest.mark.parametrize(("module", "get"), [(CLIENTS[0], "require"), (CLIENTS[1], "getObject")])
def test_functions_constants_and_objects_are_found(tmp_path: Path, module: str, get: str) -> None:
    files = {
        "script.py": PROGRAM.format(module=module, get=get),
        f"{module}.py": "class RemoteAPIClient: pass\n",
    }
    write(tmp_path, files)
    code, record = check(tmp_path / "script.py")
    assert (code, record["functions"], texts_of(record)) == (0, {}, [])
    assert list(record["regular_functions"]) == [
        "sim.getObject",
        "sim.setJointTargetPosition",
        "sim.moveToConfig",
        "sim.startSimulation",
        "sim.setStepping",
    ]
    assert list(record["regular_constants"]) == ["sim.handle_world"]
    assert objects_of(record) == ["/UR5"]
    assert texts_of(record, "note")[0].startswith(
        "it uses CoppeliaSim's ZeroMQ remote API: start the server with --zmq"
    )


MISSING = """
    from coppeliasim_zmqremoteapi_client import *
    client = RemoteAPIClient('localhost', 23000)
    sim, simUI = client.require('sim'), client.require('simUI')
    sim.getObjectPositon(1)
    sim.addDrawingObject(sim.drawing_points, 1, 0, -1, 1)
    simUI.setStyleSheet(1, 'x')
    sim.getObject('/gone', {'noError': True})
    print(sim.handle_wrld, simUI.curve_style.line)
    """


@pytest.mark.usefixtures("started_servers")
def test_what_is_missing_is_named_and_what_differs_is_told(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": MISSING})
    code, record = check(tmp_path / "script.py", "--scene", "two_link_arm")
    assert code == 1
    misspelt, constant = texts_of(record)
    assert misspelt.startswith(
        "there is no function sim.getObjectPositon here; did you mean 'sim.getObjectPosition'"
    )
    assert constant.startswith("there is no constant sim.handle_wrld here; did you mean 'sim.handle_world'")
    assert any("simUI.setStyleSheet has no effect here" in each for each in texts_of(record, "note"))


def test_what_differs_is_told_on_the_page(tmp_path: Path) -> None:
    write(tmp_path, {"script.py": MISSING})
    assert "  regular     sim.getObjectPositon, " in page_of(tmp_path / "script.py", "--differences")


def test_names_with_an_index_or_a_proxy_are_looked_for_also_in_a_comprehension(tmp_path: Path) -> None:
    text = """
        from coppeliasim_zmqremoteapi_client import RemoteAPIClient
        sim = RemoteAPIClient().require('sim')
        boxes = [sim.getObject('/Floor/box', {'index': i}) for i in range(2)]
        wheels = {i: sim.getObject('/wheel', {'index': i, 'proxy': boxes[0]}) for i in range(2)}
        options = {'noError': True}
        perhaps = sim.getObject('/gone', options), sim.getObject('/gone', {'index': 1, **options})
        """
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py", "--scene", "two_link_arm")
    assert code == 1
    assert objects_of(record) == ["/Floor/box", "/wheel"]
    assert [each.partition(";")[0] for each in texts_of(record)] == ["no object '/wheel' in two_link_arm"]


def test_an_asyncio_program_is_understood(tmp_path: Path) -> None:
    text = """
        import asyncio
        from coppeliasim_zmqremoteapi_client.asyncio import RemoteAPIClient
        async def main():
            async with RemoteAPIClient() as client:
                sim = await client.require('sim')
                await sim.getObject('/box')
        asyncio.run(main())
        """
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py")
    assert (code, list(record["regular_functions"])) == (0, ["sim.getObject"])


def test_an_object_that_the_scene_lacks_is_a_problem(tmp_path: Path) -> None:
    text = PROGRAM.format(module=CLIENTS[0], get="require").replace("/UR5", "/joint_2")
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py", "--scene", "two_link_arm")
    assert code == 1
    [problem] = texts_of(record)
    assert problem.startswith("no object '/joint_2' in two_link_arm; nearest: joint")


def test_a_program_may_use_both_apis(tmp_path: Path) -> None:
    text = f"import vrep\nfrom zmqRemoteApi import RemoteAPIClient\n{START}RemoteAPIClient().require('sim').step()\n"
    write(tmp_path, {"script.py": text})
    code, record = check(tmp_path / "script.py")
    assert (code, list(record["functions"]), list(record["regular_functions"])) == (
        0,
        ["simxStart"],
        ["sim.step"],
    )
