"""The user's router may be absent, late, or start again; or the server is the router itself."""

from __future__ import annotations

import logging
import signal
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from processes import wait_until
from ros2_world import CLOCK, JOINT_STATE, TF, Peer, Ros2World, ros2_world
from routers import free_port, router, silent

from simx_server.gateways.errors import GatewayError
from simx_server.gateways.ros2.gateway import Ros2Gateway, Ros2Options, exposure
from simx_server.gateways.ros2.wire import session
from simx_server.gateways.ros2.wire.names import Place
from simx_server.gateways.ros2.wire.session import Router

pytestmark = pytest.mark.slow

TIME, JOINTS, FIXED = f"0/clock/{CLOCK}", f"0/joint_states/{JOINT_STATE}", f"0/tf_static/{TF}"


@pytest.fixture(autouse=True)
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Try to reach the router more often than for users."""
    monkeypatch.setattr(session, "RETRY", 0.05)


def wait_for_log(server: Ros2World, caplog: pytest.LogCaptureFixture, text: str) -> None:
    server.wait_until(lambda: text in caplog.text)


def with_peer(port: int, use: Callable[[Peer], Any]) -> Any:
    peer = Peer(port)
    try:
        return use(peer)
    finally:
        peer.close()


def works(peer: Peer) -> None:
    """Check a topic, a command, a service, and what late subscribers get."""
    peer.watch()
    peer.wait_for_token(lambda token: "%step_simulation" in token)
    peer.wait_for_token(lambda token: "/NN/" in token)
    peer.listen(TIME)
    peer.listen(JOINTS)
    peer.listen(FIXED, is_late=True)
    assert peer.next(FIXED).value["transforms"]
    assert peer.trigger("start")["success"]
    peer.next(TIME)
    peer.command(["shoulder"], position=[0.4])
    peer.next(JOINTS, lambda sent: abs(sent.value["position"][0] - 0.4) < 0.05)
    assert peer.trigger("stop")["success"]


def test_without_a_router_the_server_runs_and_the_log_says_once_what_to_do(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    port = free_port()
    with ros2_world(tmp_path, router=Router(f"tcp/127.0.0.1:{port}")) as server:
        server.on_server(server.simulation.start)
        wait_for_log(server, caplog, f"ROS 2 waits for a router at tcp/127.0.0.1:{port}")
        server.wait_until(lambda: server.simulation.step_count > 200)
        assert "--ros2-router self" in caplog.text
        assert caplog.text.count("waits for a router") == 1


def test_a_late_router_brings_everything(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    port = free_port()
    with ros2_world(tmp_path, router=Router(f"tcp/127.0.0.1:{port}")) as server:
        wait_for_log(server, caplog, "waits for a router")
        with router(port):
            wait_for_log(server, caplog, "is connected to the router")
            with_peer(port, works)


def test_after_a_restart_of_the_router_everything_is_there_again(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    port = free_port()
    with ExitStack() as stack:
        with router(port):
            server = stack.enter_context(ros2_world(tmp_path, router=Router(f"tcp/127.0.0.1:{port}")))
            wait_for_log(server, caplog, "is connected to the router")
            with_peer(port, works)
        wait_for_log(server, caplog, "has gone; ROS 2 waits for it")
        server.on_server(server.simulation.start)
        server.wait_until(lambda: server.simulation.step_count > 20)
        server.on_server(server.simulation.stop)
        with router(port):
            wait_for_log(server, caplog, "is there again")
            with_peer(port, works)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="needs signals of POSIX")
def test_a_frozen_router_holds_up_neither_steps_nor_the_end(tmp_path: Path) -> None:
    port = free_port()
    with router(port) as process:
        peer = Peer(port)
        try:
            with ros2_world(tmp_path, router=Router(f"tcp/127.0.0.1:{port}")) as server:
                for key in (TIME, JOINTS, f"0/tf/{TF}"):
                    peer.listen(key)
                server.on_server(server.simulation.start)
                peer.next(JOINTS)
                process.send_signal(signal.SIGSTOP)
                count = server.simulation.step_count
                server.wait_until(lambda: server.simulation.step_count > count + 2000)
        finally:
            process.send_signal(signal.SIGCONT)
            peer.close()


def test_a_server_that_ends_without_router_ends_at_once(tmp_path: Path) -> None:
    with ros2_world(tmp_path, router=Router(f"tcp/127.0.0.1:{free_port()}")) as server:
        server.on_server(server.simulation.start)


def test_a_server_that_ends_leaves_the_graph(tmp_path: Path) -> None:
    port = free_port()
    with router(port):
        peer = Peer(port)
        peer.watch()
        with ros2_world(tmp_path, router=Router(f"tcp/127.0.0.1:{port}")):
            peer.wait_for_token(lambda token: "/NN/" in token)
        peer.wait_for_no_token()
        peer.close()


def test_two_servers_at_one_router_are_two_nodes(tmp_path: Path) -> None:
    place = Router(f"tcp/127.0.0.1:{free_port()}", is_self=True)
    (tmp_path / "other").mkdir()
    with (
        ros2_world(tmp_path, router=place) as first,
        ros2_world(tmp_path / "other", router=Router(place.endpoint), place=Place(0, "/second")) as second,
    ):
        peer = first.peer()
        peer.watch()
        for name in ("/NN/%/%/simx", "/NN/%/%second/simx", "/%second%simx%start/"):
            peer.wait_for_token(lambda token, name=name: name in token)
        assert peer.trigger("start", "0/second/simx")["success"]
        assert second.simulation.is_running
        assert not first.simulation.is_running


def test_a_node_with_the_same_name_is_warned_of(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    place = Router(f"tcp/127.0.0.1:{free_port()}", is_self=True)
    (tmp_path / "other").mkdir()
    (tmp_path / "third").mkdir()
    beside = Router(place.endpoint)
    with ros2_world(tmp_path, router=place):
        with ros2_world(tmp_path / "third", router=beside, place=Place(1)) as third:
            wait_for_log(third, caplog, "is connected to the router")
            assert "another node" not in caplog.text
        with ros2_world(tmp_path / "other", router=beside) as other:
            wait_for_log(other, caplog, "another node of ROS 2 is called /simx in domain 0")


def test_a_taken_port_is_an_error_with_advice(tmp_path: Path) -> None:
    with ros2_world(tmp_path) as server:
        options = Ros2Options(router=Router(f"tcp/127.0.0.1:{server.port}", is_self=True))
        before = dict(server.loop.service.clients.sessions)
        with pytest.raises(GatewayError, match="rmw_zenohd or another simx-server") as caught:
            Ros2Gateway(server.loop.service, options)
        assert "--ros2-router self cannot listen" in str(caught.value)
        assert server.loop.service.clients.sessions == before


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("self", Router("tcp/127.0.0.1:7447", is_self=True)),
        ("self=tcp/0.0.0.0:7450", Router("tcp/0.0.0.0:7450", is_self=True)),
        ("tcp/robot:7447", Router("tcp/robot:7447")),
    ],
)
def test_the_setting_names_a_router_or_the_server_itself(text: str, expected: Router) -> None:
    assert Router.of(text) == expected


def test_a_router_that_others_reach_is_warned_of() -> None:
    assert "SSH tunnel" in exposure(Router("tcp/0.0.0.0:7447", is_self=True))
    assert not exposure(Router("tcp/127.0.0.1:7447", is_self=True))
    assert not exposure(Router("tcp/10.0.0.7:7447"))


def test_the_server_as_router_passes_on_what_is_of_ros_2(tmp_path: Path) -> None:
    with ros2_world(tmp_path) as server:
        other, peer, curious = server.peer(), server.peer(), server.peer()
        chatter = "0/chatter/std_msgs::msg::dds_::String_/RIHS01_00"
        for key in ("**", "simx/**", "@/**"):
            curious.listen(key)
        peer.listen(chatter)

        def has_come() -> bool:
            other.put("simx/north/call/own", b"x")
            other.put(chatter, b"x")
            return bool(peer.got(chatter))

        assert wait_until(has_come, 20.0)
        assert not any(map(curious.got, ("**", "simx/**", "@/**")))


def test_no_node_answers_for_the_server_that_is_the_router(tmp_path: Path) -> None:
    asked: list[str] = []
    with ros2_world(tmp_path) as server:
        other, peer = server.peer(), server.peer()
        for key in ("0/simx/**", "0/simx/start/std_srvs::srv::dds_::Trigger_/*"):
            other.session.declare_queryable(
                key, lambda query: asked.append(str(query.key_expr)), complete=True
            )
        assert peer.trigger("start")["success"]
        assert not asked


def test_connections_that_say_nothing_keep_no_node_out(tmp_path: Path) -> None:
    with ros2_world(tmp_path) as server, silent(server.port, 300):
        for _ in range(3):
            assert server.peer().trigger("start")["success"]
