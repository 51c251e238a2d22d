"""Layouts, hashes and bytes of ROS 2 messages. The judge is rosbags, another implementation."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from random_messages import for_rosbags, made, plain
from recorded_hashes import HASHES, OLDER_HASHES

from simx_server.ros2_messages import (
    BUILT_IN,
    BY_NAME,
    SERVICES,
    MessageError,
    MessageType,
    Types,
    known_types,
)
from simx_server.ros2_messages import decoding as d

rosbags = pytest.importorskip("rosbags.typesys", reason="needs rosbags, of the extra dev")

PUBLIC = {
    # `ros2 topic info -v` prints these; people publish its output.
    "rosgraph_msgs/msg/Clock": "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "sensor_msgs/msg/Range": "b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a",
    "std_srvs/srv/Trigger": "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    "example_interfaces/srv/AddTwoInts": "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
    "simulation_interfaces/srv/StepSimulation": "913fe0653690ce6bf8f09f316e6a626747012e9fca31e26719910d417aa8565c",
}
KILTED = {
    # The packages of Kilted on the package index have these in files, computed by ROS 2's own generator.
    "action_msgs/srv/CancelGoal": "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    "action_msgs/msg/GoalStatusArray": "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
    "rcl_interfaces/msg/Log": "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac",
    "rcl_interfaces/srv/DescribeParameters": "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    "rcl_interfaces/srv/SetParametersAtomically": "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
}
FIBONACCI = {
    # The action of its test_msgs.
    "SendGoal": "d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9",
    "GetResult": "5d30fdeb21d20e117aa5f36c7b4f0b6874f1a8cf7a9c038d58f1156c5737b209",
    "FeedbackMessage": "37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e",
}
IN_ROSBAGS = [name for name in BY_NAME if name in rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY).fielddefs]


def store_of(distribution: str) -> Any:
    return rosbags.get_typestore(rosbags.Stores[f"ROS2_{distribution.upper()}"])


@pytest.fixture(scope="module")
def store() -> Any:
    return store_of("jazzy")


@pytest.mark.parametrize("name", IN_ROSBAGS)
def test_bytes_are_those_of_rosbags_and_come_back_as_the_same_values(store: Any, name: str) -> None:
    rng = random.Random(name)
    kind = BY_NAME[name]
    for _ in range(12):
        value = made(kind.layout, rng)
        data = kind.encode(value)
        assert data == bytes(store.serialize_cdr(for_rosbags(store, kind.layout, value), name))
        assert plain(kind.decode(data)) == value
        assert plain(kind.fill(value)) == value


@pytest.mark.parametrize("name", sorted(SERVICES))
def test_requests_and_responses_come_back_as_the_same_values(name: str) -> None:
    rng = random.Random(name)
    for kind in (SERVICES[name].request, SERVICES[name].response):
        value = made(kind.layout, rng)
        assert plain(kind.decode(kind.encode(value))) == value


def hashes(types: Types) -> dict[str, str]:
    """All hashes of a distribution, by name."""
    return {name: kind.hash for name, kind in {**types.messages, **types.services}.items()}


def test_the_hashes_are_those_that_were_recorded() -> None:
    assert hashes(BUILT_IN.newer) == {name: f"RIHS01_{hash_}" for name, hash_ in HASHES.items()}


def test_hashes_are_the_public_ones() -> None:
    found = {name: kind.hash for name, kind in {**BY_NAME, **SERVICES}.items()}
    assert {name: found[name] for name in PUBLIC} == {
        name: f"RIHS01_{hash_}" for name, hash_ in PUBLIC.items()
    }


def test_hashes_of_actions_and_parameters_are_those_of_kilted() -> None:
    found = {name: kind.hash for name, kind in {**BY_NAME, **SERVICES}.items()}
    assert {name: found[name] for name in KILTED} == {
        name: f"RIHS01_{hash_}" for name, hash_ in KILTED.items()
    }


def test_the_hashes_of_an_action_are_those_of_ros_own_generator() -> None:
    text = "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n"
    found = hashes(known_types({"test_msgs/action/Fibonacci": text}).newer)
    assert {name: found[f"test_msgs/action/Fibonacci_{name}"] for name in FIBONACCI} == {
        name: f"RIHS01_{hash_}" for name, hash_ in FIBONACCI.items()
    }


def test_earlier_releases_have_other_layouts_and_hashes_of_some_types() -> None:
    older, newer = hashes(BUILT_IN.older), hashes(BUILT_IN.newer)
    assert {name: hash_ for name, hash_ in older.items() if hash_ != newer[name]} == {
        name: f"RIHS01_{hash_}" for name, hash_ in OLDER_HASHES.items()
    }
    spawn = "simulation_interfaces/srv/SpawnEntity"
    assert "uri" in BUILT_IN.older.services[spawn].request.default()
    assert "entity_resource" in SERVICES[spawn].request.default()
    assert BUILT_IN.older.services[spawn].hash == f"RIHS01_{OLDER_HASHES[spawn]}"
    assert "uri" in BUILT_IN.humble.services[spawn].request.default()


def test_a_bounded_sequence_with_too_many_values_is_refused_both_ways() -> None:
    kind = BY_NAME["rcl_interfaces/msg/ParameterDescriptor"]
    data = kind.encode({"integer_range": [{"to_value": 1}]})
    assert kind.decode(data)["integer_range"][0]["to_value"] == 1
    with pytest.raises(MessageError, match="integer_range takes at most 1 values, not 2"):
        kind.fill({"integer_range": [{}, {}]})
    one = {"from_value": 0, "to_value": 1, "step": 0}
    two = kind.encode({**kind.default(), "integer_range": [one, one]})
    with pytest.raises(MessageError, match="at most 1 are valid"):
        kind.decode(two)


@pytest.mark.parametrize("distribution", ["iron", "jazzy", "kilted", "lyrical"])
def test_hashes_are_those_of_rosbags_in_each_distribution(distribution: str) -> None:
    store = store_of(distribution)
    # rosbags keeps char apart from uint8, ROS 2 does not. Lyrical no longer has Pose2D.
    without = {"std_msgs/msg/Char"} | ({"geometry_msgs/msg/Pose2D"} if distribution == "lyrical" else set())
    names = [name for name in IN_ROSBAGS if name not in without]
    assert {name: BY_NAME[name].hash for name in names} == {name: store.hash_rihs01(name) for name in names}


def test_humble_has_the_layouts_of_its_own_and_no_hashes() -> None:
    store = store_of("humble")
    for name in IN_ROSBAGS:
        kind = BUILT_IN.humble.messages[name]
        value = made(kind.layout, random.Random(name))
        assert kind.hash == "TypeHashNotSupported"
        assert kind.encode(value) == bytes(store.serialize_cdr(for_rosbags(store, kind.layout, value), name))
    assert "variance" not in BUILT_IN.humble.messages["sensor_msgs/msg/Range"].default()
    assert "variance" in BY_NAME["sensor_msgs/msg/Range"].default()
    assert BUILT_IN.humble.services["std_srvs/srv/Trigger"].hash == "TypeHashNotSupported"


def test_names_in_keys_are_those_of_ros() -> None:
    assert BY_NAME["sensor_msgs/msg/JointState"].dds_name == "sensor_msgs::msg::dds_::JointState_"
    trigger = SERVICES["std_srvs/srv/Trigger"]
    assert trigger.dds_name == trigger.response.dds_name == "std_srvs::srv::dds_::Trigger_"


@pytest.mark.parametrize(
    ("kind", "value", "recorded"),
    [
        (
            BY_NAME["rosgraph_msgs/msg/Clock"],
            {"clock": {"sec": 12, "nanosec": 345678900}},
            "00010000 0c000000 34a49a14",
        ),
        (
            BY_NAME["sensor_msgs/msg/JointState"],
            {
                "header": {"stamp": {"sec": 1, "nanosec": 2}},
                "name": ["a", "b"],
                "position": [0.1, 0.2],
            },
            "00010000 01000000 02000000 01000000 00 000000 02000000 02000000 6100 0000 02000000 6200 0000"
            "02000000 9a9999999999b93f 9a9999999999c93f 00000000 00000000",
        ),
        (SERVICES["std_srvs/srv/Trigger"].request, {}, "00010000 00"),
        (
            SERVICES["std_srvs/srv/Trigger"].response,
            {"success": True, "message": "started"},
            "00010000 01 000000 08000000 73746172746564 00",
        ),
    ],
)
def test_bytes_are_those_that_ros_recorded(kind: MessageType, value: dict[str, Any], recorded: str) -> None:
    assert kind.encode(value) == bytes.fromhex(recorded.replace(" ", ""))


IMAGE = BY_NAME["sensor_msgs/msg/Image"]
JOINTS = BY_NAME["sensor_msgs/msg/JointState"]
TWIST = BY_NAME["geometry_msgs/msg/Twist"]


def test_numbers_may_be_lists_arrays_or_packed_bytes() -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    forms = (pixels, pixels.tobytes(), pixels.ravel().tolist(), memoryview(pixels.tobytes()))
    assert len({IMAGE.encode({"data": form}) for form in forms}) == 1
    turned = pixels[::-1]
    assert IMAGE.encode({"data": turned}) == IMAGE.encode({"data": turned.tobytes()})
    values = np.array([1.5, -2.0, 3.25])
    forms = (values, values.astype(np.float32), values.tolist(), values.tobytes(), (1.5, -2, 3.25))
    assert len({JOINTS.encode({"position": form}) for form in forms}) == 1


def test_missing_fields_have_their_defaults() -> None:
    pose = BY_NAME["geometry_msgs/msg/Pose"]
    assert pose.decode(pose.encode({}))["orientation"] == {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    assert TWIST.encode({"linear": {"x": 1}}) == TWIST.encode(
        {"linear": {"x": 1.0, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    )
    assert pose.default() == pose.decode(pose.encode({}))


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        (
            "geometry_msgs/msg/Twist",
            {"linear": 3},
            "Vector3: field linear takes a table with the fields x, y, z",
        ),
        (
            "geometry_msgs/msg/Twist",
            {"linear": {"x": "fast"}},
            "field linear.x takes a number (float64), not 'fast'",
        ),
        ("geometry_msgs/msg/Twist", [1], "Twist takes a table with the fields linear, angular, not [1]"),
        ("std_msgs/msg/UInt8", {"data": 256}, "takes an integer from 0 to 255 (uint8), not 256"),
        ("std_msgs/msg/Int32", {"data": 1.5}, "takes an integer from -2147483648"),
        ("std_msgs/msg/Float32", {"data": 1e39}, "takes a number of single precision, not 1e+39"),
        ("std_msgs/msg/Int64", {"data": float("nan")}, "takes an integer"),
        ("std_msgs/msg/String", {"data": 5}, "field data takes a text, not 5"),
        ("std_msgs/msg/String", {"data": "\ud800"}, "takes a text that can be UTF-8"),
        ("sensor_msgs/msg/JointState", {"name": "abc"}, "field name takes a list, not 'abc'"),
        ("sensor_msgs/msg/JointState", {"name": ["a", 1]}, "field name[1] takes a text, not 1"),
        (
            "sensor_msgs/msg/JointState",
            {"position": [0, None]},
            "field position[1] takes a number (float64), not None",
        ),
        (
            "sensor_msgs/msg/JointState",
            {"position": b"123"},
            "takes packed values of 8 bytes each, not 3 bytes",
        ),
        (
            "sensor_msgs/msg/Imu",
            {"orientation_covariance": [1, 2]},
            "orientation_covariance takes 9 values, not 2",
        ),
        ("sensor_msgs/msg/Image", {"data": np.array([1.5])}, "takes an integer from 0 to 255"),
        ("tf2_msgs/msg/TFMessage", {"transforms": [{}, 1]}, "field transforms[1] takes a table"),
    ],
)
def test_a_wrong_value_names_the_field_and_what_is_valid(name: str, value: Any, said: str) -> None:
    with pytest.raises(MessageError) as raised:
        BY_NAME[name].encode(value)
    assert said in str(raised.value)


def test_an_unknown_field_suggests_the_nearest() -> None:
    with pytest.raises(MessageError, match=r"Twist has no field 'lineal'; did you mean linear\?"):
        TWIST.fill({"lineal": {}})


def test_whole_floats_fit_integers() -> None:
    kind = BY_NAME["std_msgs/msg/Int32"]
    assert kind.decode(kind.encode({"data": 7.0})) == {"data": 7}


def samples() -> Iterator[tuple[MessageType, bytes]]:
    for name, kind in BY_NAME.items():
        yield kind, kind.encode(made(kind.layout, random.Random(name)))


def test_each_message_cut_short_is_refused_with_the_field() -> None:
    for kind, data in samples():
        for end in range(len(data)):
            with pytest.raises(MessageError, match=kind.name):
                kind.decode(data[:end])


def test_changed_bytes_are_refused_or_read_and_nothing_else_is_raised() -> None:
    rng = random.Random(0)
    for kind, data in samples():
        for _ in range(10):
            changed = bytearray(data)
            for _ in range(rng.randrange(1, 4)):
                changed[rng.randrange(len(changed))] = rng.choice((0, 1, 127, 128, 255))
            with suppress(MessageError):
                kind.decode(bytes(changed))


@pytest.mark.parametrize(
    ("kind", "data", "said"),
    [
        (TWIST, "", "0 bytes are less than the header of CDR"),
        (TWIST, "00000000" + 48 * "00", "the bytes are big endian"),
        (TWIST, "00070000" + 48 * "00", "the header 00 07 00 00 is not that of CDR version 1"),
        (TWIST, "00010000" + 56 * "00", "8 bytes are left after the last field"),
        (
            JOINTS,
            "00010000" + 8 * "00" + "ffffffff00",
            "a string of 4294967295 bytes does not fit into 1 bytes",
        ),
        (JOINTS, "00010000" + 8 * "00" + "01000000" + "61", "a string has no final NUL"),
        (JOINTS, "00010000" + 8 * "00" + "02000000" + "ff00", "a string is not UTF-8"),
        (JOINTS, "00010000" + 12 * "00" + "ffffffff00", "4294967295 values do not fit into 1 bytes"),
        (
            JOINTS,
            "00010000" + 16 * "00" + "ffffff7f00000000",
            "2147483647 values of float64 do not fit into 0 bytes",
        ),
        (
            BY_NAME["tf2_msgs/msg/TFMessage"],
            "00010000" + "ffffffff",
            "4294967295 values do not fit into 0 bytes",
        ),
        (SERVICES["std_srvs/srv/Trigger"].request, "00010000", "a message without fields has one byte"),
    ],
)
def test_hostile_bytes_are_refused_with_the_reason(kind: MessageType, data: str, said: str) -> None:
    with pytest.raises(MessageError) as raised:
        kind.decode(bytes.fromhex(data))
    assert said in str(raised.value)


def test_the_padding_that_ros_leaves_behind_empty_sequences_is_passed_over() -> None:
    written = (
        "00010000 00000000 00000000 01000000 009c95db 01000000 02000000 61000000 01000000 00000000 0000f03f"
        "00000000 00000000 a47f0000 301474d8"
    )  # by rclpy's serialize_message
    found = JOINTS.decode(bytes.fromhex(written.replace(" ", "")))
    assert (found["name"], found["position"].tolist(), found["effort"].tolist()) == (["a"], [1.0], [])


def test_an_empty_string_of_length_zero_is_read() -> None:
    kind = BY_NAME["std_msgs/msg/String"]
    assert kind.decode(bytes.fromhex("0001000000000000")) == {"data": ""}


def test_a_message_beyond_the_limits_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    names = JOINTS.encode({"name": [""] * 1000})
    monkeypatch.setattr(d, "MOST_ITEMS", 999)
    with pytest.raises(MessageError, match="more than 999 strings, arrays and messages"):
        JOINTS.decode(names)
    monkeypatch.setattr(d, "MOST_BYTES", 1000)
    with pytest.raises(MessageError, match="bytes are more than 1,000, the limit"):
        JOINTS.decode(names)


def test_constants_are_those_of_the_definition(store: Any) -> None:
    assert BY_NAME["sensor_msgs/msg/Range"].constants == {"ULTRASOUND": 0, "INFRARED": 1}
    for name in IN_ROSBAGS:
        known = {key: value for key, _kind, value in store.fielddefs[name][0]}
        assert BY_NAME[name].constants.items() <= known.items()
