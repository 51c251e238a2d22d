"""A recording has what ROS 2 did as calls, and replays it without ROS 2."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from recordings import RecordedWorld, kinds, replay
from ros2_world import SCENE, Ros2World, free_port

from simx_server.gateways.ros2.gateway import Ros2Options
from simx_server.gateways.ros2.wire.session import Router
from simx_server.recording.records import Kind

REPLAYED = 0
CRATE = """
<mujoco>
  <worldbody><body name="crate"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody>
</mujoco>
"""


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


def test_spawned_placed_and_deleted_entities_and_worlds_are_repeated(tmp_path: Path) -> None:
    scene, file = tmp_path / "scene.xml", tmp_path / "run.simxlog"
    scene.write_text(SCENE, encoding="utf-8")
    options = Ros2Options(router=Router(f"tcp/127.0.0.1:{free_port()}", is_self=True))
    server = Ros2World(RecordedWorld(scene, file), options)
    try:
        peer = server.peer()

        def ask(kind: str, name: str, /, **request: Any) -> None:
            assert peer.call_standard(kind, name, **request)["result"]["result"] == 1

        peer.trigger("start")
        peer.trigger("pause")
        pose = {"header": {}, "pose": {"position": {"x": 0.4, "z": 3.0}, "orientation": {"w": 1.0}}}
        for name in ("one", "two"):
            resource = {"resource_string": CRATE}
            ask("SpawnEntity", "spawn_entity", name=name, entity_resource=resource, initial_pose=pose)
        twist = {"linear": {"x": 1.0}, "angular": {"y": 2.0}}
        ask(
            "SetEntityState", "set_entity_state", entity="one", state={**pose, "twist": twist}, set_twist=True
        )
        ask("StepSimulation", "step_simulation", steps=5)
        ask("DeleteEntity", "delete_entity", entity="two")
        ask("StepSimulation", "step_simulation", steps=5)
        ask("ResetSimulation", "reset_simulation", scope=3)
        ask("StepSimulation", "step_simulation", steps=5)
        ask("LoadWorld", "load_world", world_resource={"resource_string": SCENE})
        peer.trigger("start")
        peer.trigger("pause")
        ask("StepSimulation", "step_simulation", steps=5)
    finally:
        server.close()
    assert replay(file) == REPLAYED
