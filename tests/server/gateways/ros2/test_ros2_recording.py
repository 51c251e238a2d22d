"""A recording has what ROS 2 did as calls, and replays it without ROS 2."""

from __future__ import annotations

from pathlib import Path

from recordings import RecordedWorld, kinds, replay
from ros2_world import SCENE, Ros2World, free_port

from simx_server.gateways.ros2.gateway import Ros2Options
from simx_server.gateways.ros2.wire.session import Router
from simx_server.recording.records import Kind

REPLAYED = 0


def test_commands_steps_pauses_and_resets_are_repeated(tmp_path: Path) -> None:
    scene, file = tmp_path / "scene.xml", tmp_path / "run.simxlog"
    scene.write_text(SCENE, encoding="utf-8")
    options = Ros2Options(router=Router(f"tcp/127.0.0.1:{free_port()}", is_self=True))
    server = Ros2World(RecordedWorld(scene, file), options)
    try:
        peer = server.peer()
        peer.trigger("start")
        joints, scene_ = server.simulation.joints, server.simulation.scene
        elbow = scene_.resolve("elbow")
        for goal in (0.3, -0.2):
            peer.command(["shoulder", "elbow"], position=[-goal, goal])
            server.wait_until(lambda goal=goal: abs(joints.position(elbow) - goal) < 0.05)
        peer.trigger("pause")
        peer.command(["wheel"], velocity=[3.0])
        wheel = scene_.resolve("wheel")
        server.wait_until(lambda: joints.target_velocity(wheel) == 3.0)
        assert peer.call_standard("StepSimulation", "step_simulation", steps=7)["result"]["result"] == 1
        peer.trigger("reset")
        peer.trigger("start")
        count = server.simulation.step_count
        server.wait_until(lambda: server.simulation.step_count > count + 5)
        peer.trigger("stop")
    finally:
        server.close()
    assert kinds(file).count(Kind.JOINED) == 1
    assert replay(file) == REPLAYED
