"""Keys, tokens, QoS and attachments, byte for byte as rmw_zenoh writes them (recorded in other implementations)."""

from __future__ import annotations

import time

import pytest

from simx_server.gateways.ros2.endpoints import Moment
from simx_server.gateways.ros2.wire import attachment
from simx_server.gateways.ros2.wire.names import (
    Distribution,
    Kind,
    Place,
    endpoint_token,
    is_name,
    key,
    node_token,
    part_of_name,
)
from simx_server.gateways.ros2.wire.qos import CLOCK, LATCHED, SENSOR_DATA, TRANSFORMS, Qos
from simx_server.ros2_messages import BY_NAME, SERVICES

ZID = "467e23e175a288e0886ba95e0226c5da"
JOINT_STATE = BY_NAME["sensor_msgs/msg/JointState"]
TRIGGER = SERVICES["std_srvs/srv/Trigger"]


@pytest.mark.parametrize(
    ("place", "name", "expected"),
    [
        (
            Place(),
            "/joint_states",
            "0/joint_states/sensor_msgs::msg::dds_::JointState_/"
            "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
        ),
        (
            Place(7, "/arm"),
            "/joint_states",
            "7/arm/joint_states/sensor_msgs::msg::dds_::JointState_/"
            "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
        ),
    ],
)
def test_a_key_is_domain_name_type_and_hash(place: Place, name: str, expected: str) -> None:
    assert key(place, place.full(name), JOINT_STATE.dds_name, JOINT_STATE.hash) == expected


def test_the_key_of_a_service_of_the_node_has_the_nodes_name() -> None:
    place = Place()
    assert key(place, place.full("~/start"), TRIGGER.dds_name, TRIGGER.hash) == (
        "0/simx/start/std_srvs::srv::dds_::Trigger_/"
        "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
    )


def test_humble_has_one_text_in_place_of_hashes() -> None:
    assert Distribution.HUMBLE.hash_of(JOINT_STATE.hash) == "TypeHashNotSupported"
    assert Distribution.NEWER.hash_of(JOINT_STATE.hash) == JOINT_STATE.hash


def test_the_token_of_a_node_at_the_root_and_in_a_namespace() -> None:
    assert node_token(Place(), ZID, 0) == f"@ros2_lv/0/{ZID}/0/0/NN/%/%/simx"
    assert node_token(Place(7, "/lab/arm"), ZID, 3) == f"@ros2_lv/7/{ZID}/3/3/NN/%/%lab%arm/simx"


@pytest.mark.parametrize(
    ("number", "kind", "place", "name", "qos", "expected"),
    [
        (
            1,
            Kind.PUBLISHER,
            Place(),
            "/joint_states",
            Qos(),
            "0/0/1/MP/%/%/simx/%joint_states/{}/::,10:,:,:,,",
        ),
        (5, Kind.PUBLISHER, Place(), "/tf_static", LATCHED, "0/0/5/MP/%/%/simx/%tf_static/{}/:1:,1:,:,:,,"),
        (6, Kind.PUBLISHER, Place(), "/scan", SENSOR_DATA, "0/0/6/MP/%/%/simx/%scan/{}/2::,5:,:,:,,"),
        (
            2,
            Kind.SUBSCRIPTION,
            Place(7, "/arm"),
            "/joint_command",
            Qos(),
            "7/0/2/MS/%/%arm/simx/%arm%joint_command/{}/::,10:,:,:,,",
        ),
        (9, Kind.SERVER, Place(), "~/start", Qos(), "0/0/9/SS/%/%/simx/%simx%start/{}/::,10:,:,:,,"),
    ],
)
def test_the_token_of_an_endpoint(
    number: int, kind: Kind, place: Place, name: str, qos: Qos, expected: str
) -> None:
    made = endpoint_token(place, ZID, (0, number), kind, place.full(name), "pkg::T_", "RIHS01_00", qos)
    domain, rest = expected.split("/", 1)
    assert made == f"@ros2_lv/{domain}/{ZID}/{rest.format('pkg::T_/RIHS01_00')}"
    assert len(made.split("/")) == 13
    assert all(made.split("/"))


@pytest.mark.parametrize(
    ("qos", "text"),
    [
        (Qos(10), "::,10:,:,:,,"),
        (Qos(42), "::,:,:,:,,"),
        (SENSOR_DATA, "2::,5:,:,:,,"),
        (TRANSFORMS, "::,100:,:,:,,"),
        (LATCHED, ":1:,1:,:,:,,"),
        (CLOCK, "2::,1:,:,:,,"),
    ],
)
def test_qos_as_text_leaves_defaults_empty(qos: Qos, text: str) -> None:
    assert qos.text() == text


def test_an_attachment_is_33_bytes_as_recorded() -> None:
    recorded = bytes.fromhex("f701000000000000 8bf5cbe4a863ea18 10 0debce6960275aa2dd7d58cb191223a3")
    read = attachment.read(recorded)
    assert read.number == 503
    assert read.gid == recorded[17:]
    assert read.packed() == recorded


def test_an_answer_has_number_and_sender_of_its_request_and_the_present_time() -> None:
    request = attachment.read(
        bytes.fromhex("c900000000000000 003f9218a863ea18 10 1e4246dd97154e358eb5ba7ab77184a3")
    )
    before = time.time_ns()
    answer = attachment.read(attachment.answering(request))
    assert (answer.number, answer.gid) == (request.number, request.gid)
    assert before <= answer.time_ns <= time.time_ns()


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "33 bytes, not 0"),
        (bytes(32), "33 bytes, not 32"),
        (bytes(33), "16 bytes, not 0"),
        (bytes(7) + b"\x80" + bytes(8) + b"\x10" + bytes(16), "not negative"),
    ],
)
def test_a_wrong_attachment_is_refused_with_the_reason(data: bytes, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        attachment.read(data)


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("Vision_sensor#0", "Vision_sensor_0"),
        ("kinect rgb", "kinect_rgb"),
        ("3rd eye", "_3rd_eye"),
        ("#?*$", "unnamed"),
        ("camera", "camera"),
    ],
)
def test_a_name_of_the_scene_becomes_a_valid_part_of_a_name(name: str, part: str) -> None:
    assert part_of_name(name) == part
    assert is_name(f"/{part}")


def test_names_that_ros_refuses_are_no_names() -> None:
    assert is_name("/arm/joint_states")
    for bad in ("joint_states", "/", "/a//b", "/3d", "/a-b", "/a/"):
        assert not is_name(bad)


@pytest.mark.parametrize(
    ("steps", "time_step", "sec", "nanosec"),
    [(0, 0.05, 0, 0), (501, 0.01, 5, 10_000_000), (3, 1 / 3, 1, 0), (12_345_678, 0.05, 617_283, 900_000_000)],
)
def test_a_stamp_is_rounded_once_and_its_nanoseconds_stay_below_a_second(
    steps: int, time_step: float, sec: int, nanosec: int
) -> None:
    assert Moment.of(steps, time_step).stamp == {"sec": sec, "nanosec": nanosec}
