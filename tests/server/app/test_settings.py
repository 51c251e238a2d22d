"""Settings: where a value comes from, and what is said about a bad one."""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path
from typing import Any

import pytest

from simx_server.settings.derived import at_ports, of_member, of_start
from simx_server.settings.gathering import gather
from simx_server.settings.listing import list_settings
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import SETTINGS, Settings


def test_without_flags_and_variables_everything_has_its_default() -> None:
    settings = gather({}, {})
    assert settings == Settings()
    assert settings.ports == (19997, 19999)
    assert settings.auto_start
    assert settings.temporary_port == 19999
    assert settings.speed == 1.0
    assert settings.scene is None
    assert settings.workspace == Path.cwd()
    assert not settings.multicast_scouting
    assert {origin for _, _, origin in list_settings(settings)} == {"default"}


def test_flag_wins_over_variable_and_variable_over_default() -> None:
    settings = gather({"speed": "3"}, {"SIMX_SPEED": "2", "SIMX_REALM": "lab"})
    assert settings.speed == 3.0
    assert settings.realm == "lab"
    origins = {name: origin for name, _, origin in list_settings(settings)}
    assert origins["speed"] == "flag --speed"
    assert origins["realm"] == "environment SIMX_REALM"
    assert origins["duration"] == "default"


def test_scene_is_an_argument_without_a_flag() -> None:
    settings = gather({"scene": "a.xml"}, {"SIMX_SCENE": "b.xml"})
    assert settings.scene == "a.xml"
    assert ("scene", "a.xml", "argument SCENE") in list_settings(settings)


def test_switch_can_be_turned_off_by_flag_when_the_variable_says_on() -> None:
    assert gather({}, {"SIMX_START": "yes"}).start
    assert not gather({"start": False}, {"SIMX_START": "yes"}).start


@pytest.mark.parametrize("text", ["19997,19999", "19997 19999", " 19997 , 19999 "])
def test_list_in_a_variable_is_divided_by_commas_or_blanks(text: str) -> None:
    assert gather({}, {"SIMX_PORT": text}).ports == (19997, 19999)


def test_empty_variable_counts_as_absent() -> None:
    settings = gather({}, {"SIMX_SPEED": "", "SIMX_PORT": " "})
    assert settings == Settings()


def test_speed_max_is_infinite_and_shown_as_max() -> None:
    settings = gather({"speed": "MAX"}, {})
    assert settings.speed == math.inf
    assert ("speed", "max", "flag --speed") in list_settings(settings)


def test_folder_and_file_become_absolute_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "zenoh.json5").write_text("{}")
    monkeypatch.chdir(tmp_path)
    settings = gather({"workspace": ".", "config": "zenoh.json5"}, {})
    assert settings.workspace == tmp_path.resolve()
    assert settings.config == (tmp_path / "zenoh.json5").resolve()


@pytest.mark.parametrize(
    ("name", "text", "valid"),
    [
        ("speed", "fast", "a number greater than 0, or max"),
        ("speed", "0", "a number greater than 0, or max"),
        ("speed", "nan", "a number greater than 0, or max"),
        ("temporary_port", "http", "a whole number from 0 to 65535"),
        ("temporary_port", "-19997", "a whole number from 0 to 65535"),
        ("time_step", "-0.05", "seconds greater than 0, such as 0.05"),
        ("duration", "inf", "seconds greater than 0, such as 60"),
        ("realm", "a/b", "1 to 64 letters, digits, dots, dashes and underscores"),
        ("config", "missing.json5", "an existing JSON5 file of Zenoh settings"),
        ("workspace", "no/such/folder", "an existing folder"),
        ("log_level", "loud", "debug, info, warning, error"),
        ("headless", "no", "yes; there is no window to ask for"),
    ],
)
def test_bad_value_says_where_it_came_from_and_what_is_valid(name: str, text: str, valid: str) -> None:
    setting = SETTINGS[name]
    for flags, environment, origin in [
        ({name: text}, {}, f"flag {setting.flag}"),
        ({}, {setting.variable: text}, f"environment {setting.variable}"),
    ]:
        with pytest.raises(SettingError) as caught:
            gather(flags, environment)
        assert str(caught.value) == f"{origin}: {text!r} cannot be used; valid: {valid}"


def test_bad_member_of_a_list_is_named() -> None:
    with pytest.raises(SettingError, match=r"flag --port: '70000' cannot be used"):
        gather({"ports": ["19997", "70000"]}, {})
    with pytest.raises(SettingError, match=r"'7447' cannot be used; valid: PROTOCOL/ADDRESS"):
        gather({"listen": ["7447"]}, {})


def test_switch_variable_takes_only_yes_or_no() -> None:
    with pytest.raises(SettingError, match=r"SIMX_AUTO_START: 'maybe' cannot be used; valid: yes or no"):
        gather({}, {"SIMX_AUTO_START": "maybe"})
    assert not gather({}, {"SIMX_AUTO_START": "Off"}).auto_start


def test_port_given_twice_is_refused_but_zero_may_repeat() -> None:
    with pytest.raises(SettingError, match="5000 is given twice"):
        gather({"ports": ["5000", "5001", "5000"]}, {})
    assert gather({"ports": ["0", "0"]}, {}).ports == (0, 0)


def test_every_field_is_declared_once_with_a_variable_of_its_own() -> None:
    fields = [field.name for field in dataclasses.fields(Settings) if field.name != "origins"]
    assert fields == list(SETTINGS)
    variables = [setting.variable for setting in SETTINGS.values()]
    assert len(set(variables)) == len(variables)
    assert all(setting.help and setting.valid for setting in SETTINGS.values())


def test_settings_cannot_be_changed_afterwards() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        Settings().speed = 2.0  # pyright: ignore[reportAttributeAccessIssue]


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ({"replay": "R", "speed": "2"}, "flag --speed: has no meaning beside --replay; valid: one of both"),
        (
            {"count": "2", "zmq_viewers": "0"},
            "flag --zmq-viewers: with --count all servers would want the same",
        ),
        ({"replay": "R", "zmq": "0"}, "flag --zmq: has no meaning beside --replay; valid: one of both"),
        ({"replay": "R", "ros2": "0"}, "flag --ros2: has no meaning beside --replay; valid: one of both"),
        ({"replay": "R", "view": "0"}, "flag --view: has no meaning beside --replay; valid: one of both"),
        ({"replay": "R", "time_step": "0.01"}, "flag --time-step: has no meaning beside --replay"),
        ({"replay": "R", "duration": "3"}, "flag --duration: has no meaning beside --replay"),
        ({"snapshot": "S", "ports": ["0"]}, "flag --port: has no meaning beside --snapshot"),
        ({"snapshot": "S", "start": True}, "flag --start: has no meaning beside --snapshot"),
    ],
)
def test_what_only_a_server_has_is_refused_where_nobody_is_served(
    flags: dict[str, Any], said: str, tmp_path: Path
) -> None:
    recording = tmp_path / "run.simxlog"
    recording.touch()
    files = {"R": str(recording), "S": str(tmp_path / "picture.png")}
    given = {
        name: files.get(value, value) if isinstance(value, str) else value for name, value in flags.items()
    }
    with pytest.raises(SettingError, match=re.escape(said)):
        gather(given, {})


def test_a_variable_may_say_what_a_run_without_a_server_does_not_need(tmp_path: Path) -> None:
    picture = str(tmp_path / "picture.png")
    assert gather({"snapshot": picture, "duration": "3"}, {"SIMX_SPEED": "2"}).speed == 2.0


def test_a_replay_may_be_imaged_at_a_moment_and_may_allow_code(tmp_path: Path) -> None:
    recording = tmp_path / "run.simxlog"
    recording.touch()
    flags = {
        "replay": str(recording),
        "snapshot": str(tmp_path / "picture.png"),
        "duration": "3",
        "allow_code": True,
        "log_level": "debug",
    }
    assert gather(flags, {}).duration == 3.0


@pytest.mark.parametrize(
    ("legacy", "ports"),
    [
        (["0"], (19997, 19999)),
        (["19997"], (19999,)),
        (["0.0.0.0:19999"], (19997,)),
        (["19997", "19999"], (0,)),
    ],
)
def test_the_default_ports_make_room_for_original_clients(legacy: list[str], ports: tuple[int, ...]) -> None:
    settings = gather({"legacy_ports": legacy}, {})
    assert settings.ports == ports
    assert [address.rpartition(":")[2] for address in settings.legacy_ports] == [
        each.rpartition(":")[2] for each in legacy
    ]


def test_a_number_has_one_protocol_only() -> None:
    with pytest.raises(SettingError, match="5000 is given with --port too"):
        gather({"ports": ["5000"], "legacy_ports": ["5000"]}, {})
    with pytest.raises(SettingError, match="5000 is given twice"):
        gather({"legacy_ports": ["5000", "0.0.0.0:5000"]}, {})
    with pytest.raises(SettingError, match="IPv4"):
        gather({"legacy_ports": ["localhost:5000"]}, {})


def test_ports_for_original_clients_of_a_fleet_follow_those_of_the_server_before() -> None:
    settings = gather({"ports": ["5000"], "legacy_ports": ["0.0.0.0:5004", "0"], "count": "3"}, {})
    assert of_member(settings, 2).ports == (5010,)
    assert of_member(settings, 2).legacy_ports == ("0.0.0.0:5014", "127.0.0.1:0")


def test_the_zeromq_port_of_each_of_many_servers_follows_the_one_before() -> None:
    settings = gather({"zmq": "23000", "count": "3"}, {})
    assert [of_member(settings, number).zmq for number in range(3)] == [
        "127.0.0.1:23000",
        "127.0.0.1:23001",
        "127.0.0.1:23002",
    ]
    assert of_member(gather({"zmq": "0.0.0.0:0"}, {}), 5).zmq == "0.0.0.0:0"
    with pytest.raises(SettingError, match="go beyond 65535"):
        gather({"zmq": "65535", "count": "2", "ports": ["0"]}, {})


@pytest.mark.parametrize(
    ("flags", "environment", "domain"),
    [
        ({}, {"ROS_DOMAIN_ID": "5"}, None),
        ({"ros2": "ROS_DOMAIN_ID"}, {}, 0),
        ({"ros2": "ROS_DOMAIN_ID"}, {"ROS_DOMAIN_ID": "5"}, 5),
        ({"ros2": "7"}, {"ROS_DOMAIN_ID": "5"}, 7),
        ({}, {"SIMX_ROS2": "7", "ROS_DOMAIN_ID": "5"}, 7),
    ],
)
def test_the_domain_of_ros_2_is_the_given_one_else_that_of_the_environment(
    flags: dict[str, str], environment: dict[str, str], domain: int | None
) -> None:
    assert gather(flags, environment).ros2 == domain


@pytest.mark.parametrize(
    ("flags", "environment", "complaint"),
    [
        ({"ros2": "233"}, {}, "a domain from 0 to 232"),
        (
            {"ros2": "ROS_DOMAIN_ID"},
            {"ROS_DOMAIN_ID": "abc"},
            "environment ROS_DOMAIN_ID: 'abc' cannot be used",
        ),
        ({"ros2": "0", "ros2_namespace": "arm"}, {}, "a slash and a name"),
        ({"ros2": "0", "ros2_namespace": "/3d"}, {}, "a slash and a name"),
        ({"ros2": "0", "ros2_router": "localhost"}, {}, "PROTOCOL/ADDRESS of a router"),
        ({"ros2": "0", "ros2_router": "self=tcp/127.0.0.1:0"}, {}, "PROTOCOL/ADDRESS of a router"),
        ({"ros2": "0", "ros2_distro": "foxy"}, {}, "humble, iron"),
        ({"ros2_router": "self"}, {}, "flag --ros2-router: has no meaning without a node of ROS 2"),
        ({"ros2": "0", "ros2_router": "self", "count": "2"}, {}, "listen on the same endpoint"),
        ({"ros2": "232", "count": "2"}, {}, "go beyond 232"),
    ],
)
def test_settings_of_ros_2_that_cannot_be_are_told_with_what_is_valid(
    flags: dict[str, str], environment: dict[str, str], complaint: str
) -> None:
    with pytest.raises(SettingError, match=complaint):
        gather(flags, environment)


def test_each_of_many_servers_is_in_the_next_domain_of_ros_2() -> None:
    settings = gather({"ros2": "4", "count": "3"}, {})
    assert [of_member(settings, number).ros2 for number in range(3)] == [4, 5, 6]
    assert of_member(gather({"count": "3"}, {}), 2).ros2 is None


def test_what_is_written_is_no_link_to_another_file(tmp_path: Path) -> None:
    (tmp_path / "link.png").symlink_to(tmp_path / "elsewhere.png")
    with pytest.raises(SettingError, match="a file, no link, in an existing folder"):
        gather({"snapshot": str(tmp_path / "link.png")}, {})


def test_servers_of_a_fleet_are_supervised_and_a_single_one_if_asked_for() -> None:
    assert not Settings().is_supervised
    assert Settings(supervised=True).is_supervised
    assert Settings(count=2).is_supervised
    assert of_member(Settings(count=2), 1).is_supervised
    assert not of_member(Settings(count=2, supervised=False), 1).is_supervised
    assert not Settings(supervised=True, snapshot=Path("picture.png")).is_supervised  # set by a variable
    with pytest.raises(SettingError, match="--supervised: has no meaning beside --snapshot"):
        gather({"supervised": True, "snapshot": "picture.png"}, {})


def test_a_server_that_is_started_again_has_the_ports_of_the_first_and_further_films() -> None:
    first = Settings(ports=(0,), legacy_ports=("127.0.0.1:0",), zmq="127.0.0.1:0", video=Path("run/film.mp4"))
    endpoints = ["tcp/127.0.0.1:4001", "legacy/127.0.0.1:4002", "zmq/127.0.0.1:4003"]
    second = of_start(at_ports(first, [4001], endpoints), 2)
    assert (second.ports, second.legacy_ports, second.zmq) == ((4001,), ("127.0.0.1:4002",), "127.0.0.1:4003")
    assert second.zmq_viewers is None
    assert second.video == Path("run/film-2.mp4")
    assert of_start(second, 3).video == Path("run/film-3.mp4")
