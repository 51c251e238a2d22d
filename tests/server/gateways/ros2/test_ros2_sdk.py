"""Another implementation of ROS 2 over Zenoh sees and drives the server: topics both ways, services, lists."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import ROOT
from real_world import BLOCKING, handle_of
from ros2_world import Ros2World, ros2_world
from sdk_peer import SdkPeer, sdk_peer

import simx_client as v
from simx_server.gateways.ros2.wire.names import Place

pytestmark = [pytest.mark.slow, pytest.mark.gl]

JOINT_STATE = "sensor_msgs/msg/JointState"
EMPTY, TRIGGERED = "uint8 structure_needs_at_least_one_member", "bool success\nstring message"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Ros2World]:
    with ros2_world(tmp_path_factory.mktemp("sdk"), place=Place(0, "/lab")) as opened:
        yield opened


@pytest.fixture(scope="module")
def sdk(server: Ros2World) -> Iterator[SdkPeer]:
    with sdk_peer(server.port) as peer:
        yield peer


HEADER = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
CRATE = """
<mujoco>
  <worldbody><body name="crate"><freejoint/><geom type="box" size=".1 .1 .1"/></body></worldbody>
</mujoco>
"""


def pose(x: float, y: float, z: float) -> dict[str, object]:
    return {"position": {"x": x, "y": y, "z": z}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}


def command(names: list[str], position: list[float]) -> dict[str, object]:
    return {"header": HEADER, "name": names, "position": position, "velocity": [], "effort": []}


def test_its_lists_have_our_topics_services_and_types(server: Ros2World, sdk: SdkPeer) -> None:
    peer = server.peer()
    peer.watch()
    peer.wait_for_token(lambda token: "%step_simulation" in token)
    topics = dict(sdk.do("topics"))
    assert topics["/lab/joint_states"] == [JOINT_STATE]
    assert topics["/lab/joint_command"] == [JOINT_STATE]
    assert topics["/lab/clock"] == ["rosgraph_msgs/msg/Clock"]
    assert topics["/lab/tf"] == topics["/lab/tf_static"] == ["tf2_msgs/msg/TFMessage"]
    assert topics["/lab/eye/image_raw"] == ["sensor_msgs/msg/Image"]
    services = dict(sdk.do("services"))
    for verb in ("start", "stop", "pause", "reset", "step"):
        assert services[f"/lab/simx/{verb}"] == ["std_srvs/srv/Trigger"]
    assert services["/lab/step_simulation"] == ["simulation_interfaces/srv/StepSimulation"]


def test_another_domain_is_empty(server: Ros2World, sdk: SdkPeer) -> None:
    assert sdk.do("topics", 1) == []
    assert sdk.do("services", 1) == []


def test_its_info_has_our_node_namespace_and_hash(sdk: SdkPeer) -> None:
    info = str(sdk.do("info", "/lab/joint_states"))
    for part in ("simx", "/lab", "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"):
        assert part in info


def test_its_client_controls_the_run(server: Ros2World, sdk: SdkPeer) -> None:
    def call(verb: str) -> dict[str, object]:
        values = {"structure_needs_at_least_one_member": 0}
        return sdk.do("call", f"/lab/simx/{verb}", "std_srvs/srv/Trigger", EMPTY, TRIGGERED, values)

    assert call("start") == {"success": True, "message": "the simulation is started"}
    assert call("pause")["success"]
    before = server.simulation.step_count
    assert call("step")["success"]
    assert server.simulation.step_count == before + 1
    assert call("stop")["success"]
    assert not call("pause")["success"]


def test_its_standard_service_is_answered(server: Ros2World, sdk: SdkPeer) -> None:
    kind, values = "simulation_interfaces/srv/StepSimulation", {"steps": 1}
    result = "simulation_interfaces/Result result"
    answer = sdk.do("call", "/lab/step_simulation", kind, "uint64 steps", result, values)
    assert answer["result"]["result"] == 3
    assert "start and pause it first" in answer["result"]["error_message"]


STANDARD = "simulation_interfaces"


def test_its_client_reads_the_features_and_handles_an_entity(server: Ros2World, sdk: SdkPeer) -> None:
    kind = f"{STANDARD}/srv/GetSimulatorFeatures"
    values = {"structure_needs_at_least_one_member": 0}
    features = f"{STANDARD}/SimulatorFeatures features"
    answer = sdk.do("call", "/lab/get_simulator_features", kind, EMPTY, features, values)
    assert {0, 1, 10, 11, 20, 33, 40} <= set(answer["features"]["features"])

    def call(name: str, kind: str, request: str, response: str, /, **values: object) -> Any:
        response = f"{STANDARD}/Result result\n{response}"
        found = sdk.do("call", f"/lab/{name}", f"{STANDARD}/srv/{kind}", request, response, values)
        return found["result"]["result"], found

    spawn = (
        f"string name\nbool allow_renaming\n{STANDARD}/Resource entity_resource\nstring entity_namespace\n"
    )
    stamped = {"header": HEADER, "pose": pose(0.0, 0.0, 3.0)}
    code, made = call(
        "spawn_entity",
        "SpawnEntity",
        f"{spawn}geometry_msgs/PoseStamped initial_pose",
        "string entity_name",
        name="thing",
        allow_renaming=False,
        entity_resource={"uri": "", "resource_string": CRATE},
        entity_namespace="",
        initial_pose=stamped,
    )
    assert (code, made["entity_name"]) == (1, "thing")
    code, found = call(
        "get_entity_state", "GetEntityState", "string entity", f"{STANDARD}/EntityState state", entity="thing"
    )
    assert (code, found["state"]["pose"]["position"]["z"]) == (1, 3.0)
    assert call("delete_entity", "DeleteEntity", "string entity", "", entity="thing")[0] == 1
    assert call("delete_entity", "DeleteEntity", "string entity", "", entity="thing")[0] == 2


def test_its_image_is_that_of_the_remote_api_turned_upright(server: Ros2World, sdk: SdkPeer) -> None:
    cid = server.client()
    code, (width, height), pixels = v.simxGetVisionSensorImage(cid, handle_of(cid, "eye"), 0, BLOCKING)
    assert code == v.simx_return_ok
    rows = np.array(pixels, np.int16).astype(np.uint8).reshape(height, width, 3)
    sdk.do("subscribe", "/lab/eye/image_raw", "sensor_msgs/msg/Image", "2::,5:,:,:,,")
    seen = sdk.next("/lab/eye/image_raw")
    assert (seen["width"], seen["height"], seen["step"]) == (width, height, 3 * width)
    assert (seen["encoding"], seen["is_bigendian"]) == ("rgb8", 0)
    assert seen["header"]["frame_id"] == "eye_optical_frame"
    assert np.array_equal(np.array(seen["data"], np.uint8).reshape(height, width, 3), rows[::-1])
    assert len(np.unique(rows.reshape(-1, 3), axis=0)) > 2


def test_the_ur5_follows_its_joint_states_while_an_old_script_reads(tmp_path: Path) -> None:
    """Static transforms, which were sent before the other side started, arrive too."""
    names = [f"UR5_joint{number}" for number in range(1, 7)]
    goals = [0.3, -0.4, 0.5, -0.2, 0.4, 0.6]
    ur5 = ROOT / "scenes" / "ur5_rg2_kinect.xml"
    with ros2_world(tmp_path, scene=ur5) as server, sdk_peer(server.port) as sdk:
        cid = server.client()
        joints = [handle_of(cid, name) for name in names]
        sdk.do("subscribe", "/tf_static", "tf2_msgs/msg/TFMessage", ":1:,1:,:,:,,")
        fixed = {each["child_frame_id"] for each in sdk.next("/tf_static")["transforms"]}
        sdk.do("subscribe", "/joint_states", JOINT_STATE, None)
        assert v.simxSynchronous(cid, True) == v.simx_return_ok
        assert v.simxStartSimulation(cid, BLOCKING) == v.simx_return_ok
        sdk.do("publish", "/joint_command", JOINT_STATE, command(names, goals))
        state = server.simulation.joints
        server.wait_until(lambda: [state.target_position(joint) for joint in joints] == goals)
        for _ in range(60):
            assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
        read = [v.simxGetJointPosition(cid, joint, BLOCKING)[1] for joint in joints]
        now = server.on_server(lambda: server.simulation.step_count) * 50_000_000
        stamp = {"sec": now // 10**9, "nanosec": now % 10**9}
        seen = sdk.next("/joint_states", lambda message: message["header"]["stamp"] == stamp)
    positions = dict(zip(seen["name"], seen["position"], strict=True))
    assert [positions[name] for name in names] == pytest.approx(read, abs=1e-6)
    assert read == pytest.approx(goals, abs=math.radians(1))
    assert "kinect_rgb_optical_frame" in fixed
