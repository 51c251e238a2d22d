"""Scripts of a scene publish, subscribe, serve and call in ROS 2 with simROS2."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from real_world import BLOCKING
from ros2_world import Peer, Ros2World, attachment, ros2_world
from sdk_peer import sdk_peer

import simx_client as v
from simx_server.ros2_messages import BY_NAME, SERVICES

ADD = "example_interfaces/srv/AddTwoInts"

SCRIPT = """
function sysCall_init()
    sim = sim or require 'sim'
    times = simROS2.createPublisher('/times', 'std_msgs/msg/Float64')
    echo = simROS2.createPublisher('/echo', 'std_msgs/msg/Int32MultiArray', {depth = 5})
    simROS2.createSubscription('/words', 'std_msgs/msg/String', 'heard')
    simROS2.createSubscription('/bytes', 'std_msgs/msg/UInt8MultiArray', function(msg)
        simROS2.publish(echo, {data = {#msg.data, msg.data[1]}})
    end)
    simROS2.createService('/add', 'example_interfaces/srv/AddTwoInts', function(request)
        return {sum = request.a + request.b}
    end)
    client = simROS2.createClient('/peer_add', 'example_interfaces/srv/AddTwoInts')
end

function heard(msg)
    simROS2.publish(echo, {data = {#msg.data}})
end

function sysCall_sensing()
    simROS2.publish(times, {data = sim.getSimulationTime()})
end

function sysCall_thread()
    if simROS2.waitForService(client, 30) then
        local answer = simROS2.call(client, {a = 20, b = 3})
        simROS2.publish(echo, {data = {answer.sum}})
    end
end
"""

Make = Callable[..., Ros2World]


def scene_with(script: str, language: str = "lua") -> str:
    text = script.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;").replace("\n", "&#10;")
    return (
        '<mujoco><worldbody><body name="box"><geom size="0.1"/></body></worldbody>'
        f'<custom><text name="simx:{language}:box" data="{text}"/></custom></mujoco>'
    )


@pytest.fixture
def make(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Make]:
    """Opens a world with a script."""
    monkeypatch.setenv("MUJOCO_GL", "disable")
    with ExitStack() as stack:

        def opened(script: str, language: str = "lua") -> Ros2World:
            return stack.enter_context(ros2_world(tmp_path, scene=scene_with(script, language)))

        yield opened


def key(topic: str, kind: str) -> str:
    known = {**BY_NAME, **SERVICES}[kind]
    return f"0{topic}/{known.dds_name}/{known.hash}"


def send(peer: Peer, topic: str, kind: str, value: dict[str, Any]) -> None:
    peer.put(key(topic, kind), BY_NAME[kind].encode(value))


def start(world: Ros2World) -> int:
    cid = world.client()
    assert v.simxStartSimulation(cid, BLOCKING) == v.simx_return_ok
    return cid


def lines(world: Ros2World) -> list[str]:
    return world.on_server(lambda: list(world.world.parts.status_bar.messages))


def test_the_sdk_hears_tells_and_calls_a_script_and_is_called_by_it(make: Make) -> None:
    world = make(SCRIPT)
    with sdk_peer(world.port) as sdk:
        request, response = "int64 a\nint64 b", "int64 sum"
        sdk.do("serve", "/peer_add", ADD, request, response, {"sum": 23})
        sdk.do("subscribe", "/times", "std_msgs/msg/Float64", None)
        sdk.do("subscribe", "/echo", "std_msgs/msg/Int32MultiArray", None)
        start(world)
        first = sdk.next("/times")["data"]
        sdk.next("/times", lambda message: message["data"] > first)
        sdk.next("/echo", lambda message: message["data"] == [23])  # the script's call is answered
        asked = sdk.next("/peer_add")
        assert (asked["a"], asked["b"]) == (20, 3)
        sdk.do("publish", "/words", "std_msgs/msg/String", {"data": "hello"})
        sdk.next("/echo", lambda message: message["data"] == [5])
        assert sdk.do("call", "/add", ADD, request, response, {"a": 2, "b": 40})["sum"] == 42
        topics = dict(sdk.do("topics"))
        assert topics["/times"] == ["std_msgs/msg/Float64"]
        assert topics["/words"] == ["std_msgs/msg/String"]
        assert dict(sdk.do("services"))["/add"] == [ADD]


def test_a_python_script_publishes_subscribes_and_serves(make: Make) -> None:
    world = make(
        "def sysCall_init():\n"
        "    global echo\n"
        "    echo = simROS2.createPublisher('/echo', 'geometry_msgs/msg/Twist')\n"
        "    simROS2.createSubscription('/cmd', 'geometry_msgs/msg/Twist', 'heard')\n"
        "    simROS2.createService('/add', 'example_interfaces/srv/AddTwoInts', add)\n"
        "def add(request):\n"
        "    return {'sum': request['a'] + request['b']}\n"
        "def heard(message):\n"
        "    message['angular']['z'] *= 2\n"
        "    simROS2.publish(echo, message)\n",
        "python",
    )
    peer = world.peer()
    peer.listen(key("/echo", "geometry_msgs/msg/Twist"))
    start(world)
    peer.watch()
    peer.wait_for_token(lambda token: "/MS/" in token and "%cmd/" in token)
    peer.wait_for_token(lambda token: "/MP/" in token and "%echo/" in token)
    send(peer, "/cmd", "geometry_msgs/msg/Twist", {"angular": {"z": 0.5}})
    assert peer.next(key("/echo", "geometry_msgs/msg/Twist")).value["angular"]["z"] == 1.0
    peer.wait_for_token(lambda token: "/SS/" in token and "%add/" in token)
    request = SERVICES[ADD].request.encode({"a": 2**40, "b": -1})
    ((answer, _),) = peer.ask(key("/add", ADD), request, attachment())
    assert SERVICES[ADD].response.decode(answer) == {"sum": 2**40 - 1}


def test_arrays_of_bytes_are_lists_or_strings(make: Make) -> None:
    world = make(SCRIPT)
    peer = world.peer()
    echo = key("/echo", "std_msgs/msg/Int32MultiArray")
    peer.listen(echo)
    start(world)
    peer.watch()
    peer.wait_for_token(lambda token: "/MS/" in token and "%bytes/" in token)
    send(peer, "/bytes", "std_msgs/msg/UInt8MultiArray", {"data": bytes([7, 0, 255])})
    assert peer.next(echo).value["data"].tolist() == [3, 7]


def test_a_script_gets_bytes_as_strings_where_it_asks_for_them(make: Make) -> None:
    world = make(
        "function sysCall_init()\n"
        "  echo = simROS2.createPublisher('/echo', 'std_msgs/msg/UInt8MultiArray')\n"
        "  simROS2.publisherTreatUInt8ArrayAsString(echo)\n"
        "  local sub = simROS2.createSubscription('/bytes', 'std_msgs/msg/UInt8MultiArray', function(msg)\n"
        "    simROS2.publish(echo, {data = msg.data .. '!'})\n"
        "  end)\n"
        "  simROS2.subscriptionTreatUInt8ArrayAsString(sub)\n"
        "  simROS2.serviceTreatUInt8ArrayAsString(simROS2.createService('/s', 'std_srvs/srv/Empty',\n"
        "    function(r) end))\n"
        "  simROS2.clientTreatUInt8ArrayAsString(simROS2.createClient('/c', 'std_srvs/srv/Empty'))\n"
        "  simROS2.spinSome()\n"
        "end\n"
    )
    peer = world.peer()
    echo = key("/echo", "std_msgs/msg/UInt8MultiArray")
    peer.listen(echo)
    peer.watch()
    start(world)
    peer.wait_for_token(lambda token: "/MS/" in token and "%bytes/" in token)
    send(peer, "/bytes", "std_msgs/msg/UInt8MultiArray", {"data": b"\0ab"})
    assert bytes(peer.next(echo).value["data"]) == b"\0ab!"


def test_a_script_closes_what_it_has_opened(make: Make) -> None:
    world = make(
        "function sysCall_init()\n"
        "  local bool, empty = 'std_msgs/msg/Bool', 'std_srvs/srv/Empty'\n"
        "  simROS2.shutdownPublisher(simROS2.createPublisher('/one', bool))\n"
        "  local sub = simROS2.createSubscription('/two', bool, function(m) end)\n"
        "  simROS2.shutdownSubscription(sub)\n"
        "  simROS2.shutdownSubscription(sub)\n"
        "  simROS2.shutdownService(simROS2.createService('/three', empty, function(r) end))\n"
        "  simROS2.shutdownClient(simROS2.createClient('/four', empty))\n"
        "  simROS2.imageTransportShutdownPublisher(simROS2.imageTransportCreatePublisher('/five'))\n"
        "  simROS2.imageTransportShutdownSubscription(\n"
        "    simROS2.imageTransportCreateSubscription('/six', function(data, width, height) end))\n"
        "  simROS2.createPublisher('/last', bool)\n"
        "end\n"
    )
    peer = world.peer()
    peer.watch()
    start(world)
    peer.wait_for_token(lambda token: "%last/" in token)
    names = ("%one/", "%two/", "%three/", "%four/", "%five/", "%six/")
    assert not any(name in token for token in peer.tokens for name in names)


def test_a_script_sees_images_lowest_row_first(make: Make) -> None:
    world = make(
        "function sysCall_init()\n"
        "  echo = simROS2.createPublisher('/echo', 'std_msgs/msg/Int32MultiArray')\n"
        "  simROS2.imageTransportCreateSubscription('/view', function(data, width, height)\n"
        "    simROS2.publish(echo, {data = {width, height, data:byte(1, -1)}})\n"
        "  end)\n"
        "end\n"
    )
    peer = world.peer()
    echo = key("/echo", "std_msgs/msg/Int32MultiArray")
    peer.listen(echo)
    peer.watch()
    start(world)
    peer.wait_for_token(lambda token: "/MS/" in token and "%view/" in token)
    picture = {
        "width": 1,
        "height": 2,
        "step": 4,
        "encoding": "bgr8",
        "data": bytes([3, 2, 1, 0, 6, 5, 4, 0]),
    }
    for wrong in ({"encoding": "mono8"}, {"step": 2}, {"data": b"123"}):
        send(peer, "/view", "sensor_msgs/msg/Image", {**picture, **wrong})
    send(peer, "/view", "sensor_msgs/msg/Image", picture)
    assert peer.next(echo).value["data"].tolist() == [1, 2, 4, 5, 6, 1, 2, 3]


def test_topics_of_a_script_end_with_it(make: Make) -> None:
    world = make(SCRIPT)
    peer = world.peer()
    peer.watch()
    cid = start(world)
    for kind, name in (("MP", "%times/"), ("MS", "%words/"), ("SS", "%add/"), ("SC", "%peer_add/")):
        peer.wait_for_token(lambda token, kind=kind, name=name: f"/{kind}/" in token and name in token)
    assert v.simxStopSimulation(cid, BLOCKING) == v.simx_return_ok
    peer.wait_for_no_token(lambda token: "%times/" in token or "%add/" in token)
    peer.wait_for_token(lambda token: "%clock/" in token)  # the node's own stay


def test_a_response_that_does_not_fit_reaches_the_caller_as_a_refusal_where_it_can(make: Make) -> None:
    world = make(
        "function sysCall_init()\n"
        "  simROS2.createService('/check', 'std_srvs/srv/Trigger', function(r) return {done = true} end)\n"
        "end\n"
    )
    peer = world.peer()
    peer.watch()
    start(world)
    peer.wait_for_token(lambda token: "/SS/" in token and "%check/" in token)
    service = SERVICES["std_srvs/srv/Trigger"]
    ((payload, _),) = peer.ask(
        key("/check", "std_srvs/srv/Trigger"), service.request.encode({}), attachment()
    )
    answer = service.response.decode(payload)
    assert not answer["success"]
    assert "has no field 'done'" in answer["message"]


def test_images_and_transforms_of_a_script_arrive_upright(make: Make) -> None:
    world = make(
        "function sysCall_init()\n"
        "  pub = simROS2.imageTransportCreatePublisher('/view')\n"
        "end\n"
        "function sysCall_sensing()\n"
        "  simROS2.imageTransportPublish(pub, '\\1\\2\\3\\4\\5\\6\\7\\8\\9\\10\\11\\12', 2, 2, 'eye')\n"
        "  simROS2.sendTransform({header = {frame_id = 'world'}, child_frame_id = 'ball',\n"
        "    transform = {translation = {x = 1}}})\n"
        "end\n"
    )
    peer = world.peer()
    image, tf = key("/view", "sensor_msgs/msg/Image"), key("/tf", "tf2_msgs/msg/TFMessage")
    peer.listen(image)
    peer.listen(tf)
    start(world)
    seen = peer.next(image).value
    assert (seen["width"], seen["height"], seen["step"], seen["encoding"]) == (2, 2, 6, "rgb8")
    assert seen["data"].tolist() == [7, 8, 9, 10, 11, 12, 1, 2, 3, 4, 5, 6]
    assert seen["header"]["frame_id"] == "eye"
    moved = peer.next(tf, lambda sent: sent.value["transforms"][0]["child_frame_id"] == "ball").value
    assert moved["transforms"][0]["transform"]["translation"]["x"] == 1
    assert moved["transforms"][0]["transform"]["rotation"]["w"] == 1


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("simROS2.createPublisher('/a b', 'std_msgs/msg/Bool')", "'/a b' is not a name of ROS 2"),
        ("simROS2.createPublisher('/a', 'std_msgs/msg/Bool', {depht = 1})", "no 'depht'; did you mean"),
        (
            "simROS2.createPublisher('/a', 'std_msgs/msg/Bool', {reliability = 9})",
            "is one of simROS2.qos_reliab",
        ),
        (
            "simROS2.publish(simROS2.createPublisher('/a', 'std_msgs/msg/Bool'), {date = true})",
            "has no field 'date'; did you mean data?",
        ),
        (
            "simROS2.call(simROS2.createPublisher('/a', 'std_msgs/msg/Bool'))",
            "of another kind of topic or service",
        ),
        ("simROS2.call(simROS2.createClient('/a', 'std_srvs/srv/Empty'))", "works only in a thread"),
    ],
)
def test_a_wrong_call_of_a_script_says_what_is_valid(make: Make, line: str, said: str) -> None:
    world = make(f"function sysCall_init()\n{line}\nend\n")
    start(world)
    assert any(said in each for each in lines(world)), lines(world)


def test_an_unknown_type_and_what_is_not_applied_are_said_once_and_scripts_go_on(make: Make) -> None:
    world = make(
        "function sysCall_init()\n"
        "  pub = simROS2.createPublisher('/own', 'my_msgs/msg/Own')\n"
        "  simROS2.publish(pub, {anything = 1})\n"
        "  simROS2.createPublisher('/a', 'std_msgs/msg/Bool', {deadline = 1})\n"
        "  simROS2.createActionClient('/act', 'a/action/B')\n"
        "  print('went on')\n"
        "end\n"
    )
    start(world)
    found = lines(world)
    for words in (
        "the type 'my_msgs/msg/Own' is not known",
        "deadline of the quality",
        "actions of scripts",
        "went on",
    ):
        assert sum(words in each for each in found) == 1, found


def test_malformed_messages_do_not_reach_a_script(make: Make) -> None:
    world = make(SCRIPT)
    peer = world.peer()
    echo = key("/echo", "std_msgs/msg/Int32MultiArray")
    peer.listen(echo)
    peer.watch()
    start(world)
    peer.wait_for_token(lambda token: "/MS/" in token and "%words/" in token)
    words = key("/words", "std_msgs/msg/String")
    for payload in (b"", b"\0\1\0\0\xff\xff\xff\xff", np.random.default_rng(0).bytes(100)):
        peer.put(words, payload)
    send(peer, "/words", "std_msgs/msg/String", {"data": "valid"})
    assert peer.next(echo).value["data"].tolist() == [5]
