"""Parameters and their events, the log, and diagnostics, which every node has."""

from __future__ import annotations

import logging
import math
from typing import Any

import pytest
from ros2_world import Peer, Ros2World

from simx_server.gateways.ros2.content import rosout
from simx_server.ros2_messages import BY_NAME

BOOL, INTEGER, DOUBLE, STRING = range(1, 5)
DOUBLE_ARRAY = 8


def key(topic: str, kind: str) -> str:
    described = BY_NAME[kind]
    return f"0/{topic}/{described.dds_name}/{described.hash}"


def call(peer: Peer, name: str, **request: Any) -> dict[str, Any]:
    kind = "".join(word.capitalize() for word in name.split("_"))
    return peer.call(f"rcl_interfaces/srv/{kind}", f"simx/{name}", request)


def get(peer: Peer, name: str) -> dict[str, Any]:
    return call(peer, "get_parameters", names=[name])["values"][0]


def value(kind: int, **fields: Any) -> dict[str, Any]:
    return {"type": kind, **fields}


def put(peer: Peer, name: str, given: dict[str, Any]) -> str:
    """Set a parameter; return why it was refused, empty if it was not."""
    (found,) = call(peer, "set_parameters", parameters=[{"name": name, "value": given}])["results"]
    assert found["successful"] == (not found["reason"])
    return found["reason"]


def test_parameters_are_listed_with_types_and_descriptions(server: Ros2World) -> None:
    peer = server.peer()
    names = call(peer, "list_parameters")["result"]["names"]
    assert names == ["gravity", "paused", "physics_step", "scene", "speed", "time_step", "use_sim_time"]
    assert call(peer, "list_parameters", prefixes=["speed", "nothing"])["result"]["names"] == ["speed"]
    assert not call(peer, "list_parameters", prefixes=["speed"] * 1001)["result"]["names"]
    types = call(peer, "get_parameter_types", names=["speed", "gravity", "nothing"])["types"]
    assert types.tolist() == [DOUBLE, DOUBLE_ARRAY, 0]
    (found, unknown) = call(peer, "describe_parameters", names=["scene", "nothing"])["descriptors"]
    assert (found["type"], found["read_only"]) == (STRING, True)
    assert found["description"]
    assert unknown["type"] == 0
    assert get(peer, "scene")["string_value"] == "scene"
    assert get(peer, "use_sim_time")["bool_value"]
    assert get(peer, "nothing")["type"] == 0


def test_a_parameter_that_is_set_changes_the_simulation_and_is_an_event(server: Ros2World) -> None:
    peer = server.peer()
    events = key("parameter_events", "rcl_interfaces/msg/ParameterEvent")
    peer.listen(events)
    assert put(peer, "speed", value(DOUBLE, double_value=4.0)) == ""
    event = peer.next(events).value
    assert event["node"] == "/simx"
    assert event["changed_parameters"][0]["value"]["double_value"] == 4.0
    pace = server.world.loop.service.world.parameters.pace
    assert pace is not None
    assert pace.speed == 4.0
    assert put(peer, "speed", value(INTEGER, integer_value=2)) == ""
    assert get(peer, "speed")["double_value"] == 2.0
    assert put(peer, "speed", value(DOUBLE, double_value=math.inf)) == ""
    assert put(peer, "gravity", value(DOUBLE_ARRAY, double_array_value=[0.0, 0.0, -1.6])) == ""
    assert server.simulation.model.opt.gravity.tolist() == [0, 0, -1.6]
    assert put(peer, "gravity", value(DOUBLE_ARRAY, double_array_value=[0.0, 0.0, -9.81])) == ""
    assert put(peer, "time_step", value(DOUBLE, double_value=0.1)) == ""
    assert server.simulation.time_step == 0.1
    assert put(peer, "time_step", value(DOUBLE, double_value=0.05)) == ""


def test_the_run_is_paused_by_a_parameter(server: Ros2World) -> None:
    peer = server.peer()
    assert "start it first" in put(peer, "paused", value(BOOL, bool_value=True))
    peer.trigger("start")
    assert put(peer, "paused", value(BOOL, bool_value=True)) == ""
    assert get(peer, "paused")["bool_value"]
    assert put(peer, "paused", value(BOOL, bool_value=False)) == ""
    count = server.simulation.step_count
    server.wait_until(lambda: server.simulation.step_count > count)
    assert "stop it first" in put(peer, "time_step", value(DOUBLE, double_value=0.1))


@pytest.mark.parametrize(
    ("name", "given", "said"),
    [
        ("sped", value(DOUBLE, double_value=1.0), "did you mean"),
        ("scene", value(STRING, string_value="x"), "cannot be set"),
        ("speed", value(STRING, string_value="fast"), "type 3"),
        ("speed", value(200), "type 3"),
        ("speed", value(DOUBLE, double_value=0.0), "valid: from 0.001"),
        ("speed", value(DOUBLE, double_value=math.nan), "valid: from 0.001"),
        ("gravity", value(DOUBLE_ARRAY, double_array_value=[1.0]), "three finite numbers"),
        ("gravity", value(DOUBLE_ARRAY, double_array_value=[0.0, 0.0, math.inf]), "three finite numbers"),
        ("time_step", value(DOUBLE, double_value=-1.0), ""),
        ("time_step", value(DOUBLE, double_value=math.nan), ""),
    ],
)
def test_a_value_that_is_not_valid_is_refused(
    server: Ros2World, name: str, given: dict[str, Any], said: str
) -> None:
    peer = server.peer()

    def values() -> list[Any]:
        speed, step = (get(peer, each)["double_value"] for each in ("speed", "time_step"))
        return [speed, step, get(peer, "gravity")["double_array_value"].tolist()]

    before, reason = values(), put(peer, name, given)
    assert reason
    assert said in reason
    assert values() == before


def test_parameters_are_set_together_or_not_at_all(server: Ros2World) -> None:
    peer = server.peer()
    good = {"name": "speed", "value": value(DOUBLE, double_value=3.0)}
    bad = {"name": "scene", "value": value(STRING, string_value="x")}
    refused = call(peer, "set_parameters_atomically", parameters=[good, bad])["result"]
    assert not refused["successful"]
    assert "cannot be set" in refused["reason"]
    assert get(peer, "speed")["double_value"] == math.inf
    worse = {"name": "speed", "value": value(DOUBLE, double_value=-3.0)}
    assert not call(peer, "set_parameters_atomically", parameters=[good, worse])["result"]["successful"]
    assert get(peer, "speed")["double_value"] == math.inf
    assert call(peer, "set_parameters_atomically", parameters=[good])["result"]["successful"]
    assert get(peer, "speed")["double_value"] == 3.0
    put(peer, "speed", value(DOUBLE, double_value=math.inf))


def test_too_many_names_are_refused(server: Ros2World) -> None:
    assert len(call(server.peer(), "get_parameters", names=["speed"] * 1001)["values"]) == 0


def test_lines_of_the_log_are_published_also_to_late_nodes(server: Ros2World) -> None:
    peer, log = server.peer(), key("rosout", "rcl_interfaces/msg/Log")
    peer.listen(log, is_late=True)
    logging.getLogger("simx_server.somewhere").warning("look at %s", "this")
    line = peer.next(log, lambda sent: sent.value["msg"] == "look at this").value
    assert (line["level"], line["name"], line["file"]) == (30, "simx.somewhere", "test_ros2_node.py")
    assert "/" not in line["file"]
    logging.getLogger("simx_server.somewhere").error("x" * 10_000)
    line = peer.next(log, lambda sent: sent.value["level"] == 40).value
    assert len(line["msg"]) == rosout.MOST_TEXT


def test_a_flood_of_lines_leaves_out_the_oldest(server: Ros2World) -> None:
    peer, log = server.peer(), key("rosout", "rcl_interfaces/msg/Log")
    peer.listen(log)
    logger = logging.getLogger("simx_server.flood")

    def flood() -> None:
        for number in range(3 * rosout.MOST_WAITING):
            logger.warning("line %d", number)

    server.on_server(flood)
    last = 3 * rosout.MOST_WAITING - 1
    peer.next(log, lambda sent: sent.value["msg"] == f"line {last - rosout.MOST_WAITING + 1}")
    peer.next(log, lambda sent: sent.value["msg"] == f"line {last}")
    assert "line 0" not in [sent.value["msg"] for sent in peer.got(log)]


def test_diagnostics_have_state_and_problems(server: Ros2World) -> None:
    peer, topic = server.peer(), key("diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    peer.listen(topic)
    run, health = peer.next(topic).value["status"]
    assert (run["level"], run["message"]) == (0, "the simulation is stopped")
    assert (health["name"], health["hardware_id"]) == ("simx: server", "simx")
    peer.trigger("start")
    values = {}

    def has_speed(sent: Any) -> bool:
        values.update({each["key"]: each["value"] for each in sent.value["status"][0]["values"]})
        return bool(values["speed"])

    peer.next(topic, has_speed)
    assert float(values["speed"]) > 1
    assert values["state"] == "running"
    peer.trigger("pause")
    server.simulation.data.qvel[0] = float("nan")
    peer.trigger("step")
    peer.next(topic, lambda sent: sent.value["status"][0]["level"] == 2)


def test_a_run_that_is_slower_than_wanted_is_a_warning(server: Ros2World) -> None:
    peer, topic = server.peer(), key("diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
    put(peer, "speed", value(DOUBLE, double_value=1e6))
    peer.listen(topic)
    peer.trigger("start")
    warning = peer.next(topic, lambda sent: sent.value["status"][0]["level"] == 1).value["status"][0]
    assert "1e+06 is wanted" in warning["message"]
    put(peer, "speed", value(DOUBLE, double_value=math.inf))
