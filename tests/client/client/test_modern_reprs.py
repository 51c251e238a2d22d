"""The texts of the modern client's objects: without a message, and also after the server's end."""

from __future__ import annotations

import pytest
from modern_world import messages_of
from real_world import RealWorld, path_of

import simx_client as v
from simx_client import Client, batch
from simx_client.client import Joint
from simx_client.connection.clients import CLIENTS


def things(client: Client) -> list[object]:
    """One of each."""
    wrist = client.joint("wrist")
    calls = batch.Calls(0, "here")
    return [
        client, client.simulation, client.signals, client.signals.ints, client.objects(), client.objects(Joint),
        wrist, client.object("shoulder"), wrist.parent, client.joints("shoulder", "wrist"), client.camera("above"),
        client.stepping(), client.watching(lambda: wrist.position), wrist.relative_to(None),
        client.object("red").pose, batch.Batch(client.id), batch.Servers([client.id]), calls,
        calls.simxGetJointPosition(3),
    ]  # fmt: skip


def test_an_object_says_class_name_handle_and_server(client: Client) -> None:
    where = CLIENTS.by_id[client.id].where
    wrist, shoulder = client.joint("wrist"), client.object("shoulder")
    assert repr(wrist) == f"<Joint 'wrist', handle {wrist.handle}, at {where}>"
    assert repr(shoulder) == f"<Object 'shoulder' (joint), handle {shoulder.handle}, at {where}>"
    assert repr(wrist.relative_to(shoulder)) == "<Place of joint 'wrist' in the frame of joint 'shoulder'>"
    assert repr(client.joints("shoulder", "wrist")) == f"<Joints 'shoulder', 'wrist', at {where}>"
    assert repr(client.objects(Joint)) == (
        f"<Objects at {where}: 3 × joint: joint 'shoulder', joint 'wrist', joint 'axle'>"
    )
    assert repr(client) == f"<Client at {where}, id {client.id}>"


def test_the_simulation_and_stepped_mode_say_their_state(client: Client) -> None:
    where = CLIENTS.by_id[client.id].where
    client.simulation.start()
    assert repr(client.simulation) == f"<Simulation at {where}: running at the newest answer>"
    client.simulation.stop()
    assert repr(client.simulation) == f"<Simulation at {where}: stopped at the newest answer>"
    with client.stepping() as step:
        client.joint("wrist").target_velocity = 1
        assert repr(step) == f"<Stepping at {where}, in stepped mode, 1 calls set for the next step>"
    assert repr(step) == f"<Stepping at {where}, not in stepped mode>"


def test_a_repr_sends_nothing(client: Client) -> None:
    all_of_them = things(client)
    sizes = messages_of(client)
    assert all(map(repr, all_of_them))
    assert sizes == []


def test_a_repr_says_that_the_scene_the_server_or_the_client_has_gone(
    world: RealWorld, client: Client
) -> None:
    all_of_them = things(client)
    wrist = client.joint("wrist")
    world.simulation.load(path_of(world))
    client.objects()
    assert repr(wrist).endswith(", of a scene that was replaced>")
    CLIENTS.by_id[client.id]._transport.lose()  # type: ignore[union-attr]
    assert repr(client).endswith(f", server gone, id {client.id}>")
    assert all(map(repr, all_of_them))
    v.simxFinish(client.id)
    assert repr(client).endswith(", closed, id -1>")
    assert all(map(repr, all_of_them))


def test_a_repr_does_not_wait_for_a_call_of_another_thread(client: Client) -> None:
    all_of_them = things(client)
    connection = CLIENTS.by_id[client.id]

    class Held:
        def __enter__(self) -> None:
            pytest.fail("a repr waits for the connection's lock")

        def __exit__(self, *_: object) -> None: ...

    connection._lock, lock = Held(), connection._lock  # type: ignore[assignment]
    try:
        assert all(map(repr, all_of_them))
    finally:
        connection._lock = lock


def test_a_client_that_never_connected_says_so() -> None:
    assert repr(Client.__new__(Client)) == "<Client, never connected>"
