"""The topics of V-REP's ROS interface helper start, step, pause and stop the simulation."""

from __future__ import annotations

from pathlib import Path

import pytest
from ros2_world import Peer, ros2_world

from simx_server.ros2_messages import BY_NAME
from simx_server.simulation.simulation import SimulationState

SCENE = """<mujoco><worldbody><body name="box"><geom size="0.1"/></body></worldbody>
<custom><text name="simx:ros2:world" data="helper=yes"/></custom></mujoco>"""


def key(topic: str, kind: str) -> str:
    known = BY_NAME[f"std_msgs/msg/{kind}"]
    return f"0{topic}/{known.dds_name}/{known.hash}"


def send(peer: Peer, topic: str, value: bool = True) -> None:
    peer.put(key(topic, "Bool"), BY_NAME["std_msgs/msg/Bool"].encode({"data": value}))


def test_the_helpers_topics_step_pause_and_stop_the_simulation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with ros2_world(tmp_path, scene=SCENE) as world:
        simulation = world.simulation
        peer = world.peer()
        state, time, done = (
            key("/simulationState", "Int32"),
            key("/simulationTime", "Float32"),
            key("/simulationStepDone", "Bool"),
        )
        for each in (state, time, done):
            peer.listen(each)
        peer.next(state, lambda sent: sent.value["data"] == 0)
        send(peer, "/startSimulation", False)  # only true is a command
        send(peer, "/enableSyncMode")
        send(peer, "/startSimulation")
        world.wait_until(lambda: simulation.state is SimulationState.RUNNING)
        for count in (1, 2):
            send(peer, "/triggerNextStep")
            peer.next(time, lambda sent, count=count: sent.value["data"] == pytest.approx(0.05 * count))
            assert peer.next(done).value["data"] is True
            assert world.on_server(lambda: simulation.step_count) == count
        assert peer.next(state, lambda sent: sent.value["data"] != 0).value["data"] == 1
        send(peer, "/pauseSimulation")
        peer.next(state, lambda sent: sent.value["data"] == 2)
        send(peer, "/stopSimulation")
        peer.next(state, lambda sent: sent.value["data"] == 0)
        assert not peer.got(done)


def test_a_scene_without_the_key_has_none_of_these_topics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with ros2_world(tmp_path, scene=SCENE.replace("helper=yes", "rate=10")) as world:
        peer = world.peer()
        peer.watch()
        peer.wait_for_token(lambda token: "%clock/" in token)
        peer.wait_for_token(lambda token: "%simx%step/" in token)  # declared last
        assert not any("imulation" in token and "/MS/" in token for token in peer.tokens)
