"""A compiled client, in C++: that of DQ Robotics, which contains CoppeliaSim's own."""

from __future__ import annotations

import subprocess
import sys

import pytest
from zmq_world import ZmqWorld

from simx_client.protocol.cli.installing import line

INSTALL = f"{line(['dqrobotics', 'dqrobotics-interface-coppeliasim-zmq'])}, and libzmq5 of the system"
MISSING = 77
"""Exit code of the program when the package cannot be imported."""

PROGRAM = """
import sys
try:
    from dqrobotics.interfaces.coppeliasim import DQ_CoppeliaSimInterfaceZMQ
except ImportError:
    sys.exit(77)
client = DQ_CoppeliaSimInterfaceZMQ()
assert client.connect("localhost", int(sys.argv[1]), 5000)
assert client.get_object_handle("/box") == int(sys.argv[2])
client.set_stepping_mode(True)
client.start_simulation()
client.set_joint_target_velocities(["hinge"], [1.0])
for _ in range(10):
    client.trigger_next_simulation_step()
print(client.get_joint_positions(["hinge"])[0])
client.stop_simulation()
client.disconnect()
"""


def test_a_compiled_client_moves_a_joint_step_by_step(server: ZmqWorld) -> None:
    box = server.on_server(lambda: server.simulation.scene.resolve("/box"))
    command = [sys.executable, "-c", PROGRAM, str(server.port), str(box)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    if done.returncode == MISSING:
        pytest.skip(INSTALL)
    assert not done.returncode, done.stderr
    assert 0.1 < float(done.stdout.split()[-1]) < 1
    assert server.wait_until(lambda: not server.loop.service.clients.sessions)
