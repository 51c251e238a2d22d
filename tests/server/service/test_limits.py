"""Limits on data that clients make the server hold: each excess is refused with the limit's name, value and flag."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest
from handler_calls import World
from loopback import LoopbackTransport
from processes import PENDULUM, server
from real_world import BLOCKING, Open, RealWorld

import simx_client as v
from simx_client.protocol.codec import decode_delivery, encode
from simx_client.protocol.files import MAX_FILE
from simx_client.protocol.messages import Batch, Call, Operation
from simx_server.errors import CommandError
from simx_server.handlers import HANDLERS
from simx_server.limits import LimitReached, Limits
from simx_server.service.calls.work import BatchWork
from simx_server.service.watcher import Watcher
from simx_server.settings.gathering import gather
from simx_server.settings.rules import SettingError
from simx_server.settings.settings import Settings

CUBE = '<mujoco><worldbody><body name="cube"><geom size=".1"/></body></worldbody></mujoco>'


def small(**limits: int) -> World:
    world = World(CUBE)
    world.sim.limits = Limits(**limits)
    return world


def send(world: World, command: str, *arguments: Any) -> None:
    """The calls that carry a file."""
    HANDLERS[command](world.parts, cast(Any, world.client), list(arguments))


def console(world: World) -> object:
    return world.call("simxAuxiliaryConsoleOpen", "title", 10, 0, None, None, None, None)


def dialog(world: World) -> object:
    world.sim.start()
    return world.call("simxDisplayDialog", "title", "text", v.sim_dlgstyle_ok, "", None, None)


def draw(world: World) -> object:
    return world.parts.drawings.create(0, 1.0, 0.0, -1, 1)


def copied(world: World) -> object:
    return world.call("simxCopyPasteObjects", [world.sim.scene.resolve("cube")])


def dummy(world: World) -> object:
    return world.call("simxCreateDummy", 0.1, None)


def collection(world: World) -> object:
    return world.parts.collections.create(f"c{len(world.parts.collections._edited)}")


def tube(world: World) -> object:
    return world.parts.tubes.open(0, "name", 1)


@pytest.mark.parametrize(
    ("name", "grow"),
    [
        ("consoles", console),
        ("dialogs", dialog),
        ("uis", dialog),
        ("drawings", draw),
        ("collections", collection),
        ("tubes", tube),
    ],
)
def test_the_next_one_beyond_a_limit_is_refused_with_its_name_value_and_flag(name: str, grow: Any) -> None:
    world = small(**{name: 2})
    for _ in range(2):
        grow(world)
    with pytest.raises(LimitReached, match=rf"at most 2 .*\(limit '{name}'\): .*--limit {name}=N"):
        grow(world)


def test_images_that_clients_set_are_bounded_together() -> None:
    cameras = "".join(f'<camera name="eye{n}" resolution="10 10"/>' for n in range(3))
    world = World(f"<mujoco><worldbody>{cameras}</worldbody></mujoco>")
    world.sim.limits = Limits(images=1400)
    eyes = [world.sim.scene.resolve(f"eye{n}") for n in range(3)]
    for eye in (eyes[0], eyes[1], eyes[1]):  # one in the place of another needs no more room
        world.call("simxSetVisionSensorImage", eye, bytes(300), 0)
    world.call("simxSetVisionSensorImage", eyes[2], bytes(300), 0)
    world.sim.limits = Limits(images=1000)
    with pytest.raises(LimitReached, match=r"of images that vision sensors keep \(limit 'images'\)"):
        world.call("simxSetVisionSensorImage", eyes[0], bytes(300), 0)


@pytest.mark.parametrize("grow", [copied, dummy])
@pytest.mark.parametrize("running", [False, True])
def test_a_scene_that_is_full_takes_no_object_and_stays_as_it_is(grow: Any, running: bool) -> None:
    world = small(objects=3)
    if running:
        world.sim.start()
    for _ in range(2):
        grow(world)
    before, model = list(world.sim.scene.objects), world.sim.model
    with pytest.raises(LimitReached, match=r"at most 3 objects in the scene .*--limit objects=N"):
        grow(world)
    assert list(world.sim.scene.objects) == before
    assert world.sim.model is model


def test_a_file_with_too_many_objects_leaves_the_old_scene(tmp_path: Path) -> None:
    world = small(objects=1)
    (tmp_path / "two.xml").write_text(CUBE.replace("</body>", "</body><body><geom size='.1'/></body>"))
    with pytest.raises(LimitReached, match="'two' has 2"):
        world.sim.load(tmp_path / "two.xml")
    assert world.sim.scene.by_name("cube") is not None


def test_files_of_clients_are_bounded_one_by_one_and_together(tmp_path: Path) -> None:
    world = World(workspace=tmp_path)
    world.sim.limits = Limits(file=10_000, stored=20_000)
    with pytest.raises(LimitReached, match="limit 'file'"):
        send(world, "storeFile", "a", bytes(10_001))
    with pytest.raises(LimitReached, match="limit 'file'"):
        send(world, "lendFile", "a.xml", "a.xml", bytes(10_001))
    send(world, "storeFile", "a", bytes(10_000))
    send(world, "storeFile", "a", bytes(10_000))  # in its own place
    send(world, "storeFile", "b", b"counts as one block of a disk")
    with pytest.raises(LimitReached, match="limit 'stored'"):
        send(world, "storeFile", "c", bytes(6_000))
    assert not (tmp_path / "c").exists()
    world.call("simxEraseFile", "a")
    send(world, "storeFile", "c", bytes(6_000))


def test_files_lent_without_loading_have_the_room_of_one() -> None:
    world = small(file=100)
    for number in range(3):
        send(world, "lendFile", f"{number}.xml", "a.xml", bytes(60))
    assert list(world.client.lent_files) == ["2.xml"]


def test_custom_data_is_bounded() -> None:
    world = small(custom_data=10)
    world.parts.custom_data.write(-12, "a", bytes(10))
    with pytest.raises(LimitReached, match="limit 'custom_data'"):
        world.parts.custom_data.write(-12, "b", b"1")


def test_a_name_of_a_signal_that_is_a_letter_is_refused() -> None:
    world = small()
    with pytest.raises(CommandError, match="at most 1000 characters, not 1001"):
        world.call("simxSetIntegerSignal", "x" * 1001, 1)


# --- messages -------------------------------------------------------------------------------------


@pytest.fixture
def real() -> Iterator[RealWorld]:
    world = RealWorld("ur5_rg2_kinect")
    yield world
    world.close()


def test_every_call_of_a_message_that_is_too_large_is_answered(real: RealWorld) -> None:
    real.simulation.limits = Limits(message=100_000)
    cid, other = real.client(), real.client()
    assert v.simxSetStringSignal(other, "small", b"1", BLOCKING) == v.simx_return_ok
    assert v.simxSetStringSignal(cid, "large", bytes(100_000), BLOCKING) == v.simx_return_remote_error_flag
    [error] = v.simxGetLastErrors(cid, BLOCKING)[1]
    assert "limit 'message'" in error
    assert "--limit message=N" in error
    assert v.simxGetStringSignal(other, "large", BLOCKING)[0] == v.simx_return_remote_error_flag
    assert v.simxGetStringSignal(other, "small", BLOCKING) == (v.simx_return_ok, b"1")


def test_of_a_large_message_only_who_asked_is_read(real: RealWorld) -> None:
    real.simulation.limits = Limits(message=1000)
    link = LoopbackTransport(real.loop)
    link.greet(1.0)
    calls = [
        Call(7, 0, 0, "simxStartSimulation", []),
        Call(8, 1, 5, "simxSetStringSignal", ["a", bytes(1000)]),
    ]
    link.send(encode(Batch(3, 4, calls)))
    answer = link.receive(1.0)
    assert answer is not None
    replies = decode_delivery(answer).replies
    assert [(reply.call_id, reply.status) for reply in replies] == [(7, 8), (8, 8)]
    assert not real.simulation.is_running
    link.send(encode(Batch(3, 4, calls))[:-1])  # cut off
    assert link.receive(0.0) is None
    assert "cut off" in real.loop.service.clients.sessions[link.client].errors[-1]


# --- flags ----------------------------------------------------------------------------------------


def test_who_sends_faster_than_is_executed_loses_the_rest_and_is_told(world: Open) -> None:
    opened, flooding = world("pioneer_p3dx")
    other = opened.client()
    opened.simulation.limits = Limits(waiting=20)
    session = next(iter(opened.loop.service.clients.sessions.values()))
    call = Call(0, Operation.EXECUTE, 0, "simxAddStatusbarMessage", ["flood"])
    for _ in range(100):
        opened.loop.service.queue.submit(session.client, BatchWork(encode(Batch(1, 1, [call]))))
    assert v.simxGetIntegerParameter(other, v.sim_intparam_program_version, BLOCKING)[0] == v.simx_return_ok
    while len(opened.loop.service.queue):  # the other one did not have to wait for all of them
        opened.loop.turn()
    assert list(opened.parts.status_bar.messages).count("flood") == 20
    code, errors = v.simxGetLastErrors(flooding, BLOCKING)
    assert code == v.simx_return_ok
    assert "80 messages were not executed" in errors[0]
    assert "limit 'waiting'" in errors[0]


def test_so_it_is_while_a_script_runs_and_others_are_answered_all_the_same(world: Open) -> None:
    opened, _ = world("pioneer_p3dx")
    opened.client()
    opened.simulation.limits = Limits(waiting=20)
    flooding, other = opened.loop.service.clients.sessions.values()
    starts = encode(
        Batch(1, 1, [Call(0, Operation.EXECUTE, 0, "simxStartSimulation", [])])
    )  # waits for scripts
    reads = encode(Batch(1, 1, [Call(0, Operation.EXECUTE, 0, "simxGetObjects", [0])]))
    executed: list[str] = []

    class Noting(Watcher):
        def batch_comes(self, client: str, payload: bytes) -> None:
            executed.append(client)

    opened.loop.service.watchers.add(Noting())
    for _ in range(10):
        for _ in range(15):
            opened.loop.service.queue.submit(flooding.client, BatchWork(starts))
        opened.loop.service.queue.submit(other.client, BatchWork(reads))
        opened.loop.service.meanwhile.serve_others()  # as a script does
    assert executed == [other.client] * 10
    assert len(opened.loop.service.queue) == 20
    assert sum(int(text.split()[0]) for text in flooding.errors) == 130
    assert not other.errors


def test_limits_are_chosen_by_flag_and_variable() -> None:
    assert Settings().limits == Limits()
    chosen = gather({"limit": ["objects=500", "message=32M", "signal-bytes=1000"]}, {})
    assert chosen.limits == Limits(objects=500, message=32 << 20, signal_bytes=1000)
    assert gather({}, {"SIMX_LIMIT": "objects=5 consoles=1"}).limits == Limits(objects=5, consoles=1)


@pytest.mark.parametrize(
    "text",
    ["objects", "objects=", "objects=0", "objects=-1", "objects=1K", "objects=1.5", "objects=99999999999",
     "message=1T", "message=129M", "planets=9", "", "=", "objects=\u0665", "objects=nan"],
)  # fmt: skip
def test_a_limit_that_is_none_is_refused_with_all_there_are(text: str) -> None:
    with pytest.raises(SettingError, match=r"valid: NAME=N, such as objects=500 .*: message \(128M\), calls"):
        gather({"limit": [text]}, {})


def test_every_default_is_a_limit_that_may_be_chosen() -> None:
    for each in dataclasses.fields(Limits):
        assert Limits.of([f"{each.name}={each.default}"]) == Limits()


def test_who_cannot_raise_a_limit_is_not_told_to() -> None:
    with pytest.raises(LimitReached, match=r"at most 64M bytes in a file .* no --limit file=N can be higher"):
        Limits().check("file", MAX_FILE + 1, "make it smaller")


def test_a_client_too_many_is_refused_with_a_sentence(tmp_path: Path, caplog: Any) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    with server(tmp_path / "pendulum.xml", "--limit", "clients=1", ports=(0, 0)) as process:
        try:
            first = v.simxStart("127.0.0.1", process.ports[0], True, True, 5000, 5)
            assert first == 0
            assert v.simxStart("127.0.0.1", process.ports[1], True, True, 5000, 5) == -1
            assert "at most 1 clients (limit 'clients')" in caplog.text
            assert v.simxGetPingTime(first)[0] == v.simx_return_ok
            v.simxFinish(first)
            assert v.simxStart("127.0.0.1", process.ports[1], True, True, 5000, 5) == 0
        finally:
            v.simxFinish(-1)
