"""simx-run --server with scripts of CoppeliaSim's ZeroMQ remote API and of API 2: each reaches its own server."""

from __future__ import annotations

from pathlib import Path

import pytest
from launching import simx_run

from simx_client.launch.hints import hint
from simx_client.protocol.cli.installing import ZMQ_CLIENT, line

pytestmark = pytest.mark.slow

pytest.importorskip("coppeliasim_zmqremoteapi_client", reason=line([ZMQ_CLIENT]))

PROGRAM = """\
from robot import connect
client, sim = connect()
joint = sim.getObject('/joint2')
client.setStepping(True)
sim.startSimulation()
sim.setJointTargetPosition(joint, 0.25)
while sim.getSimulationTime() < 1:
    client.step()
print(round(sim.getJointPosition(joint), 2))
sim.stopSimulation()
"""

MODULE = """\
from {package} import RemoteAPIClient
def connect():
    client = RemoteAPIClient({arguments})
    return client, client.{get}('sim')
"""


@pytest.mark.parametrize(
    ("package", "arguments", "get"),
    [
        ("coppeliasim_zmqremoteapi_client", "", "require"),
        ("zmqRemoteApi", "'localhost', port=23000", "getObject"),
    ],
)
def test_the_script_moves_a_joint_of_its_own_server(
    tmp_path: Path, package: str, arguments: str, get: str
) -> None:
    (tmp_path / "robot.py").write_text(MODULE.format(package=package, arguments=arguments, get=get))
    finished = simx_run(tmp_path, PROGRAM, flags=("--server", "two_link_arm"))
    assert (finished.returncode, finished.stdout) == (0, "0.25\n"), finished.stderr


FIRST_VERSION = """\
class RemoteAPIClient:
    def __init__(self, host='localhost', port=23000):
        raise SystemExit('the first version runs')
    def getObject(self, name):
        return self.call('zmqRemoteApi.info', [name])
"""


@pytest.mark.parametrize("folder", ["", "lib"])
def test_a_carried_copy_of_the_clients_first_version_is_replaced(tmp_path: Path, folder: str) -> None:
    package = tmp_path / folder / "zmqRemoteApi"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(FIRST_VERSION)
    name = f"{folder}.zmqRemoteApi".lstrip(".")
    (tmp_path / "robot.py").write_text(MODULE.format(package=name, arguments="", get="getObject"))
    finished = simx_run(tmp_path, PROGRAM, flags=("--server", "two_link_arm"))
    assert (finished.returncode, finished.stdout) == (0, "0.25\n"), finished.stderr


def test_a_missing_client_is_named_with_the_line_that_installs_it() -> None:
    text = hint(ModuleNotFoundError("No module named 'coppeliasim_zmqremoteapi_client'"))
    assert text is not None
    assert text.endswith(line([ZMQ_CLIENT]))


OFFICIAL = """\
import sim
from sim.zmqremoteapi import ZMQRemoteAPI
port = ZMQRemoteAPI({'name': 'handshake', 'server': False}).call(None, 'getPort')
rapi = ZMQRemoteAPI({'name': 'client', 'port': port})
sim.Object._callMethod = rapi.call
joint = sim.scene.getObject('/joint2')
print(joint.type, joint.objectType, joint.joint.type)
"""

BARE = """\
import sim
joint = sim.scene.getObject('/joint2')
sim.self.setStepping(True)
sim.scene.simulation.start()
joint.setTargetPosition(0.25)
while sim.scene.simulation.time < 1:
    sim.self.step()
print(round(joint.joint.position, 2), sim.simx_opmode_blocking)
sim.scene.simulation.stop()
"""


@pytest.mark.parametrize(
    ("program", "output"), [(OFFICIAL, "joint joint revolute\n"), (BARE, "0.25 65536\n")]
)
def test_a_program_of_api_2_reaches_its_own_server(tmp_path: Path, program: str, output: str) -> None:
    finished = simx_run(tmp_path, program, flags=("--server", "two_link_arm"))
    assert (finished.returncode, finished.stdout) == (0, output), finished.stderr
