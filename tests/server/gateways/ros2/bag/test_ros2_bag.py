"""Bags of ROS 2: written live and from a recording, and read by mcap and rosbags with the definitions in the file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from processes import ROOT
from real_world import BLOCKING, RealWorld, start_stepped
from recordings import recorded, replay

import simx_client as v
from simx_server.errors import CommandError
from simx_server.gateways.ros2.bag.bag import Bag
from simx_server.gateways.ros2.bag.schemas import definition
from simx_server.outputs.packages import OutputError
from simx_server.ros2_messages import BY_NAME

mcap = pytest.importorskip("mcap.reader", reason="needs mcap, of the extra log")
typesys = pytest.importorskip("rosbags.typesys", reason="needs rosbags, of the extra dev")

PIONEER = ROOT / "scenes" / "pioneer_p3dx.xml"
BEGAN = 1_000_000_000_000_000_000


class Found(NamedTuple):
    """One message of a bag."""

    topic: str
    kind: str
    time: int
    value: Any
    """The message, decoded by rosbags from the definition in the file."""


def read(path: Path) -> Iterator[Found]:
    store = typesys.get_typestore(typesys.Stores.EMPTY)
    known: set[str] = set()
    with path.open("rb") as file:
        reader = mcap.make_reader(file)
        assert reader.get_header().profile == "ros2"
        for schema, channel, message in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            if schema.name not in known:
                known.add(schema.name)
                store.register(typesys.get_types_from_msg(schema.data.decode(), schema.name))
                assert channel.metadata["topic_type_hash"] == BY_NAME[schema.name].hash
            value = store.deserialize_cdr(message.data, schema.name)
            yield Found(channel.topic, schema.name, message.log_time, value)


def seconds(stamp: Any) -> float:
    return stamp.sec + stamp.nanosec * 1e-9


def test_a_run_is_in_the_bag_topic_by_topic_and_step_by_step(tmp_path: Path) -> None:
    world = RealWorld(PIONEER)
    bag = Bag(world.loop.service.world, tmp_path / "run.mcap", began=BEGAN)
    cid = world.embedded_client()
    start_stepped(cid)
    wheel = v.simxGetObjectHandle(cid, "Pioneer_p3dx_leftMotor", BLOCKING)[1]
    v.simxSetJointTargetVelocity(cid, wheel, 2.0, BLOCKING)
    for _ in range(20):
        assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    position = v.simxGetJointPosition(cid, wheel, BLOCKING)[1]
    v.simxStopSimulation(cid, BLOCKING)
    start_stepped(cid)
    assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    bag.close()
    world.close()
    found = list(read(tmp_path / "run.mcap"))
    topics = {each.topic for each in found}
    assert {"/clock", "/joint_states", "/tf", "/tf_static", "/odom", "/scan"} <= topics
    clocks = [each for each in found if each.topic == "/clock"]
    assert len(clocks) == 21
    assert seconds(clocks[19].value.clock) == pytest.approx(1.0)
    assert clocks[19].time == BEGAN + 1_000_000_000
    assert clocks[20].time == BEGAN + 1_050_000_000  # the second run follows the first
    assert seconds(clocks[20].value.clock) == pytest.approx(0.05)
    states = [each.value for each in found if each.topic == "/joint_states"]
    at = states[19].name.index("Pioneer_p3dx_leftMotor")
    assert states[19].position[at] == pytest.approx(position, abs=1e-6)
    (odometry,) = [
        each.value for each in found if each.topic == "/odom" and each.time == BEGAN + 1_000_000_000
    ]
    assert odometry.child_frame_id == "base_link"
    assert odometry.pose.pose.position.x > 0.01


def test_a_recording_becomes_the_same_bag_later(tmp_path: Path) -> None:
    recording = tmp_path / "run.simxlog"
    with recorded(PIONEER, recording) as place:
        cid = place.client()
        start_stepped(cid)
        for _ in range(10):
            assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    assert replay(recording, rosbag=tmp_path / "a.mcap") == 0
    assert replay(recording, rosbag=tmp_path / "b.mcap") == 0
    one, other = ([*read(tmp_path / f"{name}.mcap")] for name in "ab")
    assert len(one) > 50
    assert [(each.topic, each.time) for each in one] == [(each.topic, each.time) for each in other]
    assert sum(each.topic == "/clock" for each in one) == 10


def test_static_transforms_are_offered_to_late_nodes(tmp_path: Path) -> None:
    world = RealWorld(PIONEER)
    bag = Bag(world.loop.service.world, tmp_path / "run.mcap")
    cid = world.embedded_client()
    start_stepped(cid)
    assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    bag.close()
    world.close()
    with (tmp_path / "run.mcap").open("rb") as file:
        channels = mcap.make_reader(file).get_summary().channels.values()
    profiles = {each.topic: each.metadata["offered_qos_profiles"] for each in channels}
    assert "durability: 1" in profiles["/tf_static"]
    assert "durability: 2" in profiles["/tf"]
    assert "reliability: 2" in profiles["/scan"]


SENSORS = """<mujoco><worldbody><body name="box"><freejoint/><geom size=".1"/>
<site name="one"/><site name="two"/></body></worldbody><custom><text name="simx:model:box" data="base=yes"/>
<text name="simx:ros2:one" data="imu=/imu frame=one"/><text name="simx:ros2:two" data="imu=/imu frame=two"/>
</custom></mujoco>"""


def test_of_two_objects_with_one_topic_the_first_is_in_the_bag_as_in_ros_2(tmp_path: Path) -> None:
    (tmp_path / "box.xml").write_text(SENSORS)
    world = RealWorld(tmp_path / "box.xml")
    bag = Bag(world.loop.service.world, tmp_path / "run.mcap")
    cid = world.embedded_client()
    start_stepped(cid)
    for _ in range(3):
        assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    bag.close()
    world.close()
    found = [each.value for each in read(tmp_path / "run.mcap") if each.topic == "/imu"]
    assert [each.header.frame_id for each in found] == ["one"] * 2  # an acceleration needs two steps


def test_a_topic_with_a_fault_is_missing_and_the_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_: Any) -> Any:
        raise CommandError("no joints today")

    monkeypatch.setattr("simx_server.gateways.ros2.content.joint_states.joint_message", fail)
    world = RealWorld(PIONEER)
    bag = Bag(world.loop.service.world, tmp_path / "run.mcap")
    cid = world.embedded_client()
    start_stepped(cid)
    for _ in range(3):
        assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
    bag.close()
    world.close()
    topics = [each.topic for each in read(tmp_path / "run.mcap")]
    assert topics.count("/clock") == 3
    assert "/joint_states" not in topics
    assert caplog.text.count("the bag lacks '/joint_states': no joints today") == 1


def test_a_file_that_exists_is_not_written_over(tmp_path: Path) -> None:
    (tmp_path / "run.mcap").write_bytes(b"something")
    world = RealWorld(PIONEER)
    with pytest.raises(OutputError, match="is not written over"):
        Bag(world.loop.service.world, tmp_path / "run.mcap")
    world.close()


@pytest.mark.parametrize("name", sorted(BY_NAME))
def test_the_definition_of_each_message_is_read_by_rosbags(name: str) -> None:
    if "/action/" in name:
        pytest.skip("only messages are in bags")
    types = typesys.get_types_from_msg(definition(BY_NAME[name].layout), name)
    assert name in types
    assert [field for field, _ in types[name][1]] == [field.name for field in BY_NAME[name].layout.fields]
