"""What waits while a script runs."""

from __future__ import annotations

import pytest
from plain_world import World

import simx_client as v
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import Batch, Call
from simx_server.simulation import SimulationState


@pytest.mark.parametrize("follows", ["simxStopSimulation", "simxGetJointPosition"])
def test_what_follows_a_trigger_does_not_stop_the_pass_it_waits_for(
    follows: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The client's next batch has it executed, but not in the middle of that pass if it interferes."""
    world = World()
    client = world.client()
    v.simxSynchronous(client, True)
    v.simxStartSimulation(client, v.simx_opmode_blocking)
    seen: list[tuple[SimulationState, int]] = []

    def send(message_id: int, *names: str) -> None:
        calls = [Call(1000, 0, 0, name, [1] if "Joint" in name else []) for name in names]
        world.engine.submit(world.transports[client].client, encode(Batch(message_id, 0, calls)))

    def runs_long() -> None:
        send(12, "simxGetJointPosition")
        world.engine.serve_others()
        seen.append((world.simulation.state, len(world.engine._inbox)))

    monkeypatch.setattr(world.simulation, "advance", runs_long)
    send(11, "simxSynchronousTrigger", follows)
    world.settle()
    is_stop = follows == "simxStopSimulation"
    assert seen == [(SimulationState.RUNNING, int(is_stop))]
    world.settle()
    assert world.simulation.state is (SimulationState.STOPPED if is_stop else SimulationState.RUNNING)
    assert len(world.engine._inbox) == 0
    world.close()
