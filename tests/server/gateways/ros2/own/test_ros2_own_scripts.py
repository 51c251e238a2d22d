"""Scripts of a scene use the user's own messages and services in ROS 2; recordings have their definitions."""

from __future__ import annotations

from pathlib import Path

import pytest
from own_package import SET_NAME, STATUS, write_package
from real_world import BLOCKING, start_stepped
from recordings import recorded, replay, rewrite
from ros2_world import Ros2World, attachment, ros2_world
from sdk_peer import sdk_peer

import simx_client as v
from simx_client.protocol.cli.exit_codes import DIVERGED, FAILURE
from simx_server.recording.recorder import DIGEST_EVERY
from simx_server.recording.records import Kind, Record
from simx_server.ros2_messages import known_types, read_packages

SCRIPT = f"""
function sysCall_init()
    sim = sim or require 'sim'
    message = simROS2.createInterface('{STATUS}')
    status = simROS2.createPublisher('/status', '{STATUS}')
    echo = simROS2.createPublisher('/echo', 'std_msgs/msg/String')
    simROS2.createSubscription('/wanted', '{STATUS}', function(msg)
        simROS2.publish(echo, {{data = msg.name .. ' ' .. msg.wheels[2].speed .. ' ' .. #msg.both}})
    end)
    simROS2.createService('/set_name', '{SET_NAME}', function(request)
        message.name = request.name
        return {{success = request.times == 3, message = 'hello ' .. request.name}}
    end)
    client = simROS2.createClient('/peer_name', '{SET_NAME}')
    sim.setIntegerSignal('limits', #message.limits)
end

function sysCall_sensing()
    message.wheels = {{{{speed = sim.getSimulationTime()}}}}
    simROS2.publish(status, message)
end

function sysCall_thread()
    if simROS2.waitForService(client, 30) then
        simROS2.publish(echo, {{data = simROS2.call(client, {{name = 'script'}}).message}})
    end
end
"""


def scene_with(script: str) -> str:
    text = script.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;").replace("\n", "&#10;")
    return (
        '<mujoco><worldbody><body name="box"><geom size="0.1"/></body></worldbody>'
        f'<custom><text name="simx:lua:box" data="{text}"/></custom></mujoco>'
    )


def start(world: Ros2World) -> None:
    assert v.simxStartSimulation(world.client(), BLOCKING) == v.simx_return_ok


REQUEST, RESPONSE = "string<=20 name\nuint32 times", "bool success\nstring message"


@pytest.mark.slow
def test_a_script_publishes_subscribes_serves_and_calls_with_own_types(tmp_path: Path) -> None:
    write_package(tmp_path)
    texts = read_packages([tmp_path])
    types = known_types(texts).newer
    kind, string = types.messages[STATUS], types.messages["std_msgs/msg/String"]
    with (
        ros2_world(tmp_path, scene=scene_with(SCRIPT), own=texts) as world,
        sdk_peer(world.port) as sdk,
    ):
        # The SDK reads the same definition by itself, computes its hash, and finds the service by it.
        sdk.do(
            "serve", "/peer_name", SET_NAME, REQUEST, RESPONSE, {"success": True, "message": "from the SDK"}
        )
        peer = world.peer()
        status = f"0/status/{kind.dds_name}/{kind.hash}"
        echo = f"0/echo/{string.dds_name}/{string.hash}"
        peer.listen(status)
        peer.listen(echo)
        peer.watch()
        start(world)
        found = kind.decode(peer.next(status).payload)
        assert (found["name"], found["limits"].tolist()) == ("robby", [0.5, 1.5])
        assert len(found["wheels"]) == 1
        peer.next(echo, lambda sent: string.decode(sent.payload)["data"] == "from the SDK")
        asked = sdk.next("/peer_name")
        assert (asked["name"], asked["times"]) == ("script", 2)  # the default of the definition
        peer.wait_for_token(lambda token: "/MS/" in token and "%wanted/" in token and kind.hash in token)
        message = {"name": "peer", "wheels": [{}, {"speed": 2.5}]}
        peer.put(f"0/wanted/{kind.dds_name}/{kind.hash}", kind.encode(message))
        peer.next(echo, lambda sent: string.decode(sent.payload)["data"] == "peer 2.5 2")
        answer = sdk.do("call", "/set_name", SET_NAME, REQUEST, RESPONSE, {"name": "rosa", "times": 3})
        assert answer == {"success": True, "message": "hello rosa"}
        peer.next(status, lambda sent: kind.decode(sent.payload)["name"] == "rosa")
        # Bytes that are not such a message do not reach the script.
        peer.put(f"0/wanted/{kind.dds_name}/{kind.hash}", b"\0\1\0\0" + b"\xff" * 40)
        service = types.services[SET_NAME]
        request = service.request.encode({"name": "end", "times": 3})
        ((payload, _),) = peer.ask(f"0/set_name/{service.dds_name}/{service.hash}", request, attachment())
        assert service.response.decode(payload)["message"] == "hello end"


def test_a_recording_has_the_definitions_that_its_scripts_fill_in(tmp_path: Path) -> None:
    folder = write_package(tmp_path)
    scene, file = tmp_path / "scene.xml", tmp_path / "run.simxlog"
    scene.write_text(scene_with(SCRIPT), encoding="utf-8")
    with recorded(scene, file, ros2_messages=(folder,)) as place:
        cid = place.client()
        start_stepped(cid)
        for _ in range(DIGEST_EVERY + 1):
            assert v.simxSynchronousTrigger(cid) == v.simx_return_ok
        assert v.simxGetIntegerSignal(cid, "limits", BLOCKING)[1] == 2
    (folder / "msg" / "Status.msg").unlink()
    assert replay(file) == 0
    rewrite(file, lambda records: [[Kind.HEADER, {**records[0][1], "ros2_messages": {}}], *records[1:]])
    assert replay(file) == DIVERGED
    for hostile in ({"../../../x/msg/A": "bool x"}, {"A": ""}, {"a/msg/A": 3}, ["a"], {"a/msg/A": "A x"}):

        def change(records: list[Record], hostile: object = hostile) -> list[Record]:
            return [[Kind.HEADER, {**records[0][1], "ros2_messages": hostile}], *records[1:]]

        rewrite(file, change)
        assert replay(file) == FAILURE


def test_a_type_that_no_folder_has_is_named_in_the_log_once(tmp_path: Path) -> None:
    with ros2_world(tmp_path, scene=scene_with(SCRIPT)) as world:
        start(world)
        lines = world.on_server(lambda: list(world.world.parts.status_bar.messages))
    assert sum(f"'{STATUS}' is not known" in each for each in lines) == 1
    assert any("--ros2-messages" in each for each in lines)
