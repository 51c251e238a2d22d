"""Packages of the user's own messages, services and actions are read; hostile ones are refused."""

from __future__ import annotations

import random
import struct
from pathlib import Path
from typing import Any

import pytest
from own_package import DRIVE, FILES, PACKAGE, SET_NAME, STATUS, write_package
from random_messages import for_rosbags, made, plain

from simx_server.ros2_messages import (
    BUILT_IN,
    DefinitionError,
    KnownTypes,
    MessageError,
    known_types,
    own,
    read_packages,
)
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError

rosbags = pytest.importorskip("rosbags.typesys", reason="needs rosbags, of the extra dev")


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> KnownTypes:
    root = tmp_path_factory.mktemp("workspace")
    write_package(root)
    return known_types(read_packages([root]))


@pytest.fixture(scope="module")
def store() -> Any:
    """rosbags with the messages of the package, which it reads from the same texts."""
    made = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
    for name in ("Wheel", "Status"):
        made.register(rosbags.get_types_from_msg(FILES[f"msg/{name}.msg"], f"{PACKAGE}/msg/{name}"))
    return made


def test_bytes_and_hashes_of_own_messages_are_those_of_rosbags(known: KnownTypes, store: Any) -> None:
    kind = known.newer.messages[STATUS]
    assert kind.hash == store.hash_rihs01(STATUS)
    rng = random.Random(0)
    for _ in range(20):
        value = made(kind.layout, rng)
        data = kind.encode(value)
        assert data == bytes(store.serialize_cdr(for_rosbags(store, kind.layout, value), STATUS))
        assert plain(kind.decode(data)) == value


def test_defaults_and_constants_are_those_of_the_files(known: KnownTypes) -> None:
    kind = known.newer.messages[STATUS]
    default = kind.default()
    assert (default["name"], default["limits"], default["is_ready"]) == ("robby", [0.5, 1.5], True)
    assert [each["speed"] for each in default["both"]] == [0.5, 0.5]
    assert default["wheels"] == default["notes"] == []
    assert plain(kind.decode(kind.encode({}))) == default
    assert kind.constants == {"DEFAULT_NAME": '"robby'}  # ROS 2 too ends a line at the first #
    assert known.newer.messages[f"{PACKAGE}/msg/Wheel"].constants == {"LEFT": 0, "RIGHT": 1}


def test_services_and_actions_are_known_as_parts(known: KnownTypes) -> None:
    service = known.newer.services[SET_NAME]
    assert service.request.default() == {"name": "", "times": 2}
    assert service.dds_name == "my_robot::srv::dds_::SetName_"
    assert service.request.hash == service.hash != known.newer.services["std_srvs/srv/SetBool"].hash
    assert known.newer.services[f"{DRIVE}_SendGoal"].request.default()["goal"] == {"metres": 0.0}
    assert f"{DRIVE}_FeedbackMessage" in known.newer.messages
    assert f"{DRIVE}_Goal" not in known.newer.messages
    assert known.humble.messages[STATUS].hash == "TypeHashNotSupported"
    assert known.older.messages[STATUS].hash == known.newer.messages[STATUS].hash


def test_limits_of_strings_and_sequences_hold_both_ways(known: KnownTypes) -> None:
    kind = known.newer.messages[STATUS]
    with pytest.raises(MessageError, match="field name takes at most 20 characters, not 21"):
        kind.fill({"name": "x" * 21})
    with pytest.raises(MessageError, match="field limits takes at most 3 values, not 4"):
        kind.fill({"limits": [0.0] * 4})
    long = kind.encode({**kind.default(), "name": "ä" * 21})
    with pytest.raises(MessageError, match="a string has 21 characters, and at most 20 are valid"):
        kind.decode(long)


def test_a_copy_of_a_type_of_the_server_is_passed_over_and_another_one_is_logged(
    caplog: pytest.LogCaptureFixture,
) -> None:
    texts = {
        "std_msgs/msg/Bool": "bool data",
        "std_msgs/msg/Int8": "int16 data",
        "a/msg/A": "std_msgs/Int8 x",
    }
    found = known_types(texts)
    assert found.newer.messages["std_msgs/msg/Int8"].hash == BUILT_IN.newer.messages["std_msgs/msg/Int8"].hash
    assert "std_msgs/msg/Int8 differs from the server's own definition, which is kept" in caplog.text
    assert "std_msgs/msg/Bool" not in caplog.text
    assert "a/msg/A" in found.newer.messages


def test_wide_strings_are_units_of_32_bits_as_ros_2_sends_them() -> None:
    kind = known_types({"a/msg/A": "wstring<=5 x\nwstring[] y"}).newer.messages["a/msg/A"]
    data = kind.encode({"x": "aß\U0001f600", "y": ["", "b"]})
    units = [4, 0x61, 0xDF, 0xD83D, 0xDE00, 2, 0, 1, 0x62]
    assert data == struct.pack("<4s9I", b"\0\1\0\0", *units)
    assert kind.decode(data) == {"x": "aß\U0001f600", "y": ["", "b"]}
    for bad, said in (
        ([9], "a wide string of 9 units does not fit into 0 bytes"),
        ([1, 0x10000], "a unit of more than 16 bits"),
        ([1, 0xD83D], "a wide string is not UTF-16"),
        ([6, *[0x61] * 6], "a string has 6 characters, and at most 5 are valid"),
    ):
        with pytest.raises(MessageError, match=said):
            kind.decode(struct.pack(f"<4s{len(bad)}I", b"\0\1\0\0", *bad))


DEEP = {f"a/msg/M{number}": f"M{number + 1} x" for number in range(60)} | {"a/msg/M60": "bool x"}
WIDE = {f"a/msg/M{number}": f"M{number + 1} x\nM{number + 1} y" for number in range(30)} | {
    "a/msg/M30": "bool x"
}
HUGE = {f"a/msg/M{number}": f"M{number + 1}[999999999] x" for number in range(3)} | {"a/msg/M3": "bool x"}


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ({"a/msg/A": "B x", "a/msg/B": "A y"}, "contains itself, which no message can: a/msg/A -> a/msg/B -> a"),
        ({"a/msg/A": "A[] x"}, "contains itself"),
        (DEEP, "has more than 40 messages within each other"),
        (WIDE, "at most 10,000 and 1,000,000 are possible"),
        (HUGE, "at most 10,000 and 1,000,000 are possible"),
        ({"a/msg/A": "uint8[999999999] x"}, "at most 10,000 and 1,000,000 are possible"),
        ({"a/msg/A": "Thing x"}, "the type 'a/msg/Thing' is not known"),
        ({"a/msg/A": "std_msgs/Heder x"}, "did you mean 'std_msgs/msg/Header'"),
        ({"a/msg/A": "float64"}, "'float64' is not the definition of a field"),
        ({"a/msg/A": "float64 x y = 3"}, "'y = 3' is not a value of float64"),
        ({"a/msg/A": "float64 __class__"}, "is not the definition of a field"),
        ({"a/msg/A": "float64 aB"}, "'aB' is not a name"),
        ({"a/msg/A": "float64 x\nint8 x"}, "x is defined twice"),
        ({"a/msg/A": "int8 low=1"}, "'low' is not a name"),
        ({"a/msg/A": "int8 X=128"}, "128 is not from -128 to 127"),
        ({"a/msg/A": "int8 x 1e9"}, "'1e9' is not a value of int8"),
        ({"a/msg/A": "float64[0] x"}, "an array has at least one value"),
        ({"a/msg/A": "float64[2] x [1]"}, "its default has 1 values"),
        ({"a/msg/A": "float64<=3 x"}, "only strings have a limit"),
        ({"a/msg/A": 'string<=3 x "long"'}, "its default has more than 3 characters"),
        ({"a/msg/A": "float64 x 1" + 9999 * "0" + "e"}, "is not a value of float64"),
        ({"a/msg/A": "int64 x " + 9999 * "1"}, "is not a value of int64"),
        ({"a/msg/A": "std_msgs/Header x 3"}, "a message within a message has no default"),
        ({"a/msg/A": "bool x\n---\nbool y"}, "it has 1 lines with ---, and a definition of this kind has 0"),
        ({"a/srv/A": "bool x"}, "it has 0 lines with ---, and a definition of this kind has 1"),
    ],
)  # fmt: skip
def test_definitions_that_cannot_be_used_are_refused_with_the_reason(
    texts: dict[str, str], said: str
) -> None:
    with pytest.raises(DefinitionError) as raised:
        known_types(texts)
    assert said in str(raised.value)
    assert next(iter(texts)).split("/")[0] in str(raised.value)


def test_folders_that_cannot_be_used_are_refused_with_the_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(*folders: Path) -> str:
        with pytest.raises(DefinitionError) as raised:
            read_packages(folders)
        return str(raised.value)

    assert "has no definition; valid is the folder of a package" in refused(tmp_path)
    one, other = (write_package(tmp_path / name, files={"msg/A.msg": f"bool {name}"}) for name in "xy")
    assert "my_robot/msg/A is defined twice, and differently" in refused(one, other)
    assert "'Bad-Name' does not name a package" in refused(write_package(tmp_path / "n", "Bad-Name"))
    assert "does not name a type" in refused(write_package(tmp_path / "t", files={"msg/a_b.msg": ""}))
    large = write_package(tmp_path / "l", files={"msg/A.msg": "#" * (own.MOST_TEXT + 1)})
    assert "has more than 262,144 bytes" in refused(large)
    (large / "msg" / "A.msg").write_bytes(b"\xff\xfe")
    assert "is not UTF-8" in refused(large)
    monkeypatch.setattr(own, "MOST_FILES", 1)
    assert "has more than 1 definitions" in refused(write_package(tmp_path / "m"))
    monkeypatch.setattr(own, "MOST_FOLDERS", 2)
    assert "has more than 2 folders" in refused(tmp_path)


def test_the_same_package_may_be_given_twice_and_copies_of_builds_are_passed_over(tmp_path: Path) -> None:
    folder = write_package(tmp_path)
    write_package(tmp_path / "build", files={"msg/Wheel.msg": "bool broken"})
    assert read_packages([folder, tmp_path, folder]) == read_packages([folder])


def test_the_flag_takes_folders_and_has_no_meaning_beside_a_recording(tmp_path: Path) -> None:
    settings = gather({"ros2_messages": [str(tmp_path)]}, {})
    assert settings.ros2_messages == (tmp_path,)
    (tmp_path / "run.simxlog").touch()
    with pytest.raises(SettingError, match="has no meaning beside --replay"):
        gather({"ros2_messages": [str(tmp_path)], "replay": str(tmp_path / "run.simxlog")}, {})
    with pytest.raises(SettingError, match="an existing folder"):
        gather({"ros2_messages": [str(tmp_path / "none")]}, {})
