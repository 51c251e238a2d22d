"""The physics thread's loop: passes, stepped mode, who leaves, what streams cost."""

import gc
import itertools
import math
import time
import weakref
from concurrent.futures import Future
from types import SimpleNamespace
from typing import cast

import pytest
from plain_world import HANDLERS, Joints, World

import simx_client as v
from simx_client.connection.timeouts import MAX_UNANSWERED
from simx_client.protocol.codec import decode_delivery, encode
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.messages import Batch, Call, Operation
from simx_server.service.answers import publishing
from simx_server.service.calls.registry import Handler
from simx_server.service.calls.work import BatchWork
from simx_server.service.clients.sessions import ClientSession, Link
from simx_server.service.clock import Pacer
from simx_server.simulation.simulation import SimulationState


@pytest.fixture
def world():
    world = World()
    yield world
    world.close()


def _passes(world):
    return world.simulation.passes


def test_a_trigger_makes_exactly_one_pass_and_answers_after_it(world):
    cid = world.client()
    assert v.simxSynchronous(cid, True) == 0
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    for _ in range(5):
        world.settle()
    assert _passes(world) == 0
    for expected in (1, 2, 3):
        assert v.simxSynchronousTrigger(cid) == 0
        assert _passes(world) == expected


def test_stepped_mode_may_be_armed_with_0_1_and_before_or_after_the_start(world):
    cid = world.client()
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    assert v.simxSynchronous(cid, 1) == 0
    before = _passes(world)
    v.simxGetPingTime(cid)
    v.simxGetPingTime(cid)
    assert _passes(world) <= before + 1
    assert v.simxSynchronous(cid, 0) == 0
    v.simxGetPingTime(cid)
    world.settle()
    assert _passes(world) > before


def test_a_trigger_without_stepped_mode_or_without_a_running_simulation_is_8(world):
    cid = world.client()
    assert v.simxSynchronousTrigger(cid) == 8
    v.simxSynchronous(cid, True)
    assert v.simxSynchronousTrigger(cid) == 8
    errors = v.simxGetLastErrors(cid, v.simx_opmode_blocking)[1]
    assert "stepped mode is off" in errors[0]
    assert "does not run" in errors[1]


def test_values_set_before_a_trigger_act_on_its_pass_and_streams_show_it_right_after(world):
    cid = world.client()
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    v.simxGetJointPosition(cid, 3, v.simx_opmode_streaming)
    for value in (1.0, 2.0, 3.0):
        v.simxSetJointPosition(cid, 3, value, v.simx_opmode_oneshot)
        v.simxSynchronousTrigger(cid)
        assert v.simxGetJointPosition(cid, 3, v.simx_opmode_buffer) == (0, value)
    log = [entry for entry in world.simulation.log if entry[0] in ("set", "pass")]
    assert log == [
        ("set", 3, 1.0),
        ("pass", 1),
        ("set", 3, 2.0),
        ("pass", 2),
        ("set", 3, 3.0),
        ("pass", 3),
    ]


def test_answers_that_wait_for_a_pass_do_not_come_after_newer_ones(world):
    one, other = world.client(), world.client()
    for cid in (one, other):
        assert v.simxSynchronous(cid, True) == 0
    v.simxStartSimulation(one, v.simx_opmode_blocking)
    assert v.simxGetJointPosition(one, 1, v.simx_opmode_blocking) == (0, 0.0)
    v.simxPauseCommunication(one, True)
    v.simxGetJointPosition(one, 1, v.simx_opmode_oneshot)
    v.simxSynchronousTrigger(one)
    v.simxPauseCommunication(one, False)  # no pass comes: the other client does not trigger
    v.simxSetJointPosition(other, 1, 0.5, v.simx_opmode_blocking)
    v.simxGetJointPosition(one, 1, v.simx_opmode_oneshot)
    v.simxSynchronousTrigger(other)
    world.settle()
    assert _passes(world) == 1
    assert v.simxGetJointPosition(one, 1, v.simx_opmode_buffer) == (0, 0.5)


def test_all_stepped_clients_must_trigger(world):
    one, two = world.client(), world.client(timeout=0.02)
    for cid in (one, two):
        v.simxSynchronous(cid, True)
    v.simxStartSimulation(one, v.simx_opmode_blocking)
    assert v.simxSynchronousTrigger(two) & v.simx_return_timeout_flag
    assert _passes(world) == 0
    assert v.simxSynchronousTrigger(one) == 0
    assert _passes(world) == 1


def test_a_stepped_client_that_dies_lets_the_simulation_go(world):
    cid = world.client()
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    v.simxGetJointPosition(cid, 3, v.simx_opmode_streaming)
    world.settle()
    world.transports[cid].lose()
    world.settle()
    assert _passes(world) > 0
    assert not world.loop.service.clients.sessions


def test_a_stop_ends_stepped_mode_and_lets_a_waiting_trigger_go(world):
    one, two = world.client(), world.client(timeout=0.02)
    for cid in (one, two):
        v.simxSynchronous(cid, True)
    v.simxStartSimulation(one, v.simx_opmode_blocking)
    v.simxSynchronousTrigger(two)
    v.simxStopSimulation(one, v.simx_opmode_blocking)
    assert not any(session.is_stepping for session in world.loop.service.clients.sessions.values())
    v.simxStartSimulation(one, v.simx_opmode_blocking)
    world.settle()
    assert _passes(world) > 0


def test_start_and_trigger_in_one_message_work_in_this_order(world):
    cid = world.client()
    v.simxSynchronous(cid, True)
    v.simxPauseCommunication(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_oneshot)
    v.simxPauseCommunication(cid, False)
    assert v.simxSynchronousTrigger(cid) == 0
    assert _passes(world) == 1


def test_a_paused_simulation_makes_no_pass_and_a_start_resumes_it(world):
    cid = world.client()
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    v.simxPauseSimulation(cid, v.simx_opmode_blocking)
    before = _passes(world)
    v.simxGetPingTime(cid)
    world.settle()
    assert _passes(world) == before
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.settle()
    assert _passes(world) > before


def test_joining_by_the_starting_port_starts_a_stopped_simulation():
    world = World(starting_port=19)
    world.client(port=20)
    assert world.simulation.state is SimulationState.STOPPED
    world.client(port=19)
    assert world.simulation.state is SimulationState.RUNNING
    world.close()


def test_equal_streams_of_several_clients_are_computed_once_a_step(world):
    clients = [world.client() for _ in range(5)]
    for cid in clients:
        v.simxGetJointPosition(cid, 3, v.simx_opmode_streaming)
    world.settle()
    counted = world.loop.service.metrics.command_times["simxGetJointPosition"].counts
    before = sum(counted)
    world.simulation.start()
    world.settle()
    assert sum(counted) == before + 1
    for cid in clients:
        assert v.simxGetJointPosition(cid, 3, v.simx_opmode_buffer)[0] == 0


def test_equal_images_of_several_clients_are_asked_for_once_a_step(world):
    clients = [world.client() for _ in range(5)]
    for cid in clients:
        v.simxGetVisionSensorImage(cid, 3, 0, v.simx_opmode_streaming)
    world.settle()
    pictures = world.simulation.pictures
    for picture in pictures:
        picture.set_result(([1, 1], bytes(3)))
    asked = len(pictures)
    world.simulation.start()
    world.settle()
    assert len(pictures) == asked + 1
    pictures[-1].set_result(([1, 1], bytes((1, 2, 3))))
    for cid in clients:
        assert v.simxGetVisionSensorImage(cid, 3, 0, v.simx_opmode_buffer) == (0, [1, 1], [1, 2, 3])


def test_streams_that_end_while_their_client_is_published_to_do_no_harm(world, caplog):
    cid = world.client()
    for joint in (1, 2, 3):
        v.simxGetJointPosition(cid, joint, v.simx_opmode_streaming)
    world.settle()
    (session,) = world.loop.service.clients.sessions.values()

    class EndingAnother(Joints):
        def get(self, handle, default):
            session.streams.cancel(max(session.streams.by_id))
            return super().get(handle, default)

    world.simulation.joints = EndingAnother({1: 1.5})
    world.simulation.start()
    world.settle()
    assert not session.streams.by_id
    assert not caplog.text


def test_streams_that_take_too_long_come_after_the_next_steps(world, monkeypatch):
    monkeypatch.setattr(publishing, "LONGEST", -60.0)
    cid = world.client()
    for joint in (1, 2, 3):
        v.simxGetJointPosition(cid, joint, v.simx_opmode_streaming)
    world.settle()
    (session,) = world.loop.service.clients.sessions.values()
    before = [share.round for share in session.streams.shares()]
    for expected in (1, 2, 3):
        world.loop.service.publisher.publish([session], after_step=True)
        rounds = [share.round for share in session.streams.shares()]
        assert sum(now > then for now, then in zip(rounds, before, strict=True)) == expected
    assert len(set(rounds)) == 3


def test_values_are_of_one_instant_however_long_other_programs_had_the_processor(world, monkeypatch):
    cid = world.client()
    for joint in (1, 2, 3):
        v.simxGetJointPosition(cid, joint, v.simx_opmode_streaming)
    world.settle()
    (session,) = world.loop.service.clients.sessions.values()
    before = [share.round for share in session.streams.shares()]
    seconds = itertools.count()  # of the wall's clock, between two looks at it; this thread's stands still
    clocks = SimpleNamespace(
        perf_counter=lambda: float(next(seconds)), thread_time=lambda: 0.0, monotonic=time.monotonic
    )
    monkeypatch.setattr(publishing, "time", clocks)
    world.loop.service.publisher.publish([session], after_step=True)
    after = [share.round for share in session.streams.shares()]
    assert all(now > then for now, then in zip(after, before, strict=True))
    assert not session.streams.is_cut


def test_clients_whose_streams_had_to_wait_come_first_after_the_next_step(world, monkeypatch):
    monkeypatch.setattr(publishing, "LONGEST_FOR_ALL", 0.0)
    clients = [world.client() for _ in range(3)]
    for cid in clients:
        v.simxGetJointPosition(cid, 1, v.simx_opmode_streaming)
    world.settle()
    sent = []
    publish = world.loop.service.publisher._publish_client
    monkeypatch.setattr(
        world.loop.service.publisher,
        "_publish_client",
        lambda session, *arguments, **more: (
            sent.append(session.client),
            publish(session, *arguments, **more),
        ),
    )
    for _ in range(6):
        world.loop.service.publisher.publish(world.loop.service.clients.sessions.values(), after_step=True)
    assert sent == [*world.loop.service.clients.sessions] * 2


def test_an_image_that_a_trigger_waits_for_is_gone_when_it_was_sent():
    session = ClientSession("client", "name", 19997, cast(Link, SimpleNamespace()))
    session.set_stepping(True)
    triggered = session.trigger(is_running=True)
    pictures = [Future(), Future()]
    session.release_triggers(after=pictures)
    gone = [weakref.ref(each) for each in pictures]
    gc.disable()  # what keeps itself stays until the collector comes, and that may be never
    try:
        pictures.pop(0).set_result(bytes(1))
        assert not triggered.done()
        pictures.pop(0).set_result(bytes(1))
        assert triggered.done()
        assert [each() for each in gone] == [None, None]
    finally:
        gc.enable()


def test_a_client_may_come_while_streams_are_computed(world, monkeypatch):
    cid = world.client()
    v.simxGetJointPosition(cid, 3, v.simx_opmode_streaming)
    world.settle()
    publish = world.loop.service.publisher._publish_client

    def come(*arguments, **more):
        world.loop.service.clients.join(
            "late", "late", 0, world.transports[cid]
        )  # as while a streamed call runs a script
        publish(*arguments, **more)

    monkeypatch.setattr(world.loop.service.publisher, "_publish_client", come)
    world.loop.service.publisher.publish(world.loop.service.clients.sessions.values(), after_step=True)
    assert len(world.loop.service.clients.sessions) == 2


def test_a_stream_that_another_client_arms_meanwhile_is_sent_in_the_same_step(world):
    cid, told = world.client(), []
    v.simxGetJointPosition(cid, 1, v.simx_opmode_streaming)
    world.settle()
    link = SimpleNamespace(
        deliver=lambda payload: None, publish=told.append, close=lambda: None, copies_positions=False
    )
    world.loop.service.clients.join("other", "other", 0, link)
    arming = [Call(7, Operation.STREAM, 0, "simxGetJointPosition", [2])]

    class ArmingAnother(Joints):
        def get(self, handle, default):
            if handle == 1 and arming:
                world.loop.service.queue.submit("other", BatchWork(encode(Batch(1, 0, [arming.pop()]))))
                for event in world.loop.service.queue.at_hand():
                    world.loop.service.handling.handle(event)
            return super().get(handle, default)

    world.simulation.joints = ArmingAnother({1: 1.5, 2: 2.5})
    world.simulation.start()
    world.settle()
    assert v.simxGetJointPosition(cid, 1, v.simx_opmode_buffer) == (0, 1.5)
    assert [(each, value.answer[1]) for each, value in told[0].of_streams()] == [(7, [2.5])]


def test_unchanged_streams_are_repeated_after_a_quarter_second_and_changed_ones_sent_at_once(
    world, monkeypatch
):
    clock, told = [100.0], []
    clocks = {"perf_counter": time.perf_counter, "thread_time": time.thread_time}
    monkeypatch.setattr(publishing, "time", SimpleNamespace(monotonic=lambda: clock[0], **clocks))
    link = SimpleNamespace(
        deliver=lambda payload: None, publish=told.append, close=lambda: None, copies_positions=False
    )
    world.loop.service.clients.join("reader", "reader", 0, link)
    world.loop.service.queue.submit(
        "reader", BatchWork(encode(Batch(1, 0, [Call(7, Operation.STREAM, 0, "simxGetJointPosition", [2])])))
    )

    def values_after(seconds):
        clock[0] += seconds
        told.clear()
        world.loop.service.publisher.publish(world.loop.service.clients.sessions.values(), after_step=True)
        payloads = [payload for values in told if (payload := values.packed())]
        return [reply.values for payload in payloads for reply in decode_delivery(payload).replies]

    world.settle()
    values_after(1.0)
    assert values_after(0.24) == []
    assert values_after(0.02) == [[0.0]]
    assert values_after(0.24) == []
    world.simulation.joints[2] = 1.5
    assert values_after(0.0) == [[1.5]]
    assert values_after(0.24) == []
    assert values_after(0.02) == [[1.5]]


def test_streamed_sets_of_two_clients_are_both_executed(world):
    one, two = world.client(), world.client()
    v.simxSetJointPosition(one, 1, 1.0, v.simx_opmode_streaming)
    v.simxSetJointPosition(two, 2, 2.0, v.simx_opmode_streaming)
    world.simulation.start()
    world.settle()
    assert world.simulation.joints == {1: 1.0, 2: 2.0}


def test_all_small_values_of_a_client_belong_to_one_instant(world):
    cid = world.client()
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    for handle in range(20):
        v.simxGetJointPosition(cid, handle, v.simx_opmode_streaming)
    for step in range(1, 4):
        world.simulation.joints = Joints(dict.fromkeys(range(20), float(step)))
        v.simxSynchronousTrigger(cid)
        values = {v.simxGetJointPosition(cid, handle, v.simx_opmode_buffer) for handle in range(20)}
        assert values == {(0, float(step))}


def test_a_client_that_does_not_read_gets_the_newest_not_a_backlog(world):
    cid = world.client()
    v.simxGetJointPosition(cid, 3, v.simx_opmode_streaming)
    world.simulation.start()
    for value in range(50):
        world.simulation.joints[3] = float(value)
        world.settle()
    assert len(world.transports[cid]._stream) == 1
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_buffer) == (0, 49.0)


def test_unreadable_bytes_are_an_error_of_that_client_only(world):
    cid, other = world.client(), world.client()
    world.transports[cid].send(b"\xff\xfe rubbish")
    world.settle()
    assert "not a message" in v.simxGetLastErrors(cid, v.simx_opmode_blocking)[1][0]
    assert v.simxGetLastErrors(other, v.simx_opmode_blocking) == (0, [])


@pytest.mark.parametrize(
    ("command", "arguments", "text"),
    [
        ("simxNoSuchThing", [], "there is no command 'simxNoSuchThing'"),
        ("simxStart", ["127.0.0.1", 1, 1, 1, 1, 1], "there is no command"),
        ("simxGetJointPosition", [], "takes jointHandle; got 0 arguments"),
        ("simxGetJointPosition", ["x"], "jointHandle must be a 32-bit integer"),
        ("simxSetJointPosition", [1, math.inf], "position must be a finite number"),
    ],
)
def test_a_wrong_call_is_answered_with_what_would_be_right(world, command, arguments, text):
    cid = world.client()
    transport = world.transports[cid]
    transport.send(encode(Batch(0, 0, [Call(1, 0, 0, command, arguments)])))
    delivery = decode_delivery(transport.receive(1.0))
    assert delivery.replies[0].status == 8
    assert text in delivery.replies[0].values[0]


@pytest.mark.parametrize(
    ("command", "arguments"),
    [("simxGetJointPosition", [[1]]), ("simxGetJointPosition", [{"a": 1}]), ("simxNoSuchThing", [[]])],
)
def test_a_stream_with_wrong_arguments_is_an_error_once_and_never_a_crash(world, command, arguments):
    cid = world.client()
    transport = world.transports[cid]
    transport.send(encode(Batch(0, 0, [Call(1, Operation.STREAM, 0, command, arguments)])))
    world.simulation.start()
    for _ in range(3):
        world.settle()
    assert [reply.status for reply in decode_delivery(transport.receive(0)).replies] == [8]
    assert _passes(world) == 3
    assert transport.newest() is None


def test_failing_streams_fill_no_log_however_many_they_are(world, caplog):
    caplog.set_level("INFO", "simx_server")
    cid = world.client()
    for handle in range(1, 61):
        v.simxGetJointPosition(cid, -handle, v.simx_opmode_streaming)
    for number in range(60):
        v.simxCallScriptFunction(cid, "", number, "crash", [], [], [], b"", v.simx_opmode_streaming)
    world.simulation.start()
    for _ in range(5):
        world.settle()
    assert caplog.text.count("simxGetJointPosition of loopback failed") == 60
    assert caplog.text.count("simxCallScriptFunction of loopback failed") == 1


def test_a_streamed_value_that_cannot_be_sent_is_an_error_and_all_others_arrive(world, caplog):
    cid = world.client()
    for joint in (1, 2):
        v.simxGetJointPosition(cid, joint, v.simx_opmode_streaming)
    world.settle()
    world.simulation.joints.update({1: object(), 2: 2.0})
    world.simulation.start()
    world.settle()
    world.settle()
    assert v.simxGetJointPosition(cid, 1, v.simx_opmode_buffer)[0] == v.simx_return_remote_error_flag
    assert v.simxGetJointPosition(cid, 2, v.simx_opmode_buffer) == (0, 2.0)
    assert "cannot send a object" in v.simxGetLastErrors(cid, v.simx_opmode_blocking)[1][0]
    assert caplog.text.count("Traceback") == 1


@pytest.mark.parametrize("mode", [v.simx_opmode_streaming, v.simx_opmode_streaming + 1])
def test_so_it_is_with_several_results_or_a_delay(world, mode, monkeypatch):
    cid = world.client()
    v.simxCallScriptFunction(cid, "where", 1, "what", [], [], [], b"", mode)
    v.simxGetJointPosition(cid, 2, v.simx_opmode_streaming)
    world.settle()
    odd = Handler(BY_NAME["simxCallScriptFunction"], lambda *_: (object(), [], [], b""), False)
    monkeypatch.setitem(HANDLERS, "simxCallScriptFunction", odd)
    (session,) = world.loop.service.clients.sessions.values()
    for stream in session.streams.by_id.values():
        stream.next_due = 0.0
    world.simulation.joints[2] = 2.0
    world.simulation.start()
    world.settle()
    assert v.simxCallScriptFunction(cid, "where", 1, "what", [], [], [], b"", v.simx_opmode_buffer)[0] == 8
    assert v.simxGetJointPosition(cid, 2, v.simx_opmode_buffer) == (0, 2.0)


def test_what_a_client_asks_for_twice_is_computed_once(world):
    """As others may than simx_client, which has one stream of a key."""
    cid = world.client()
    calls = [Call(1000 + number, Operation.STREAM, 0, "simxGetJointPosition", [1]) for number in range(3)]
    world.loop.service.queue.submit(world.transports[cid].client, BatchWork(encode(Batch(1, 0, calls))))
    world.settle()
    asked = []

    class Counted(Joints):
        def get(self, handle, default):
            asked.append(handle)
            return 1.0

    world.simulation.joints = Counted()
    world.simulation.start()
    world.settle()
    assert asked == [1]


def test_streams_that_cannot_be_sent_end_alone(world, caplog, monkeypatch):
    one, two = world.client(), world.client()
    for cid in (one, two):
        v.simxGetJointPosition(cid, cid, v.simx_opmode_streaming)
    world.settle()
    first = next(iter(world.loop.service.clients.sessions.values()))
    monkeypatch.setattr(first.link, "publish", lambda payload: 1 / 0)
    world.simulation.joints[two] = 2.0
    world.simulation.start()
    world.settle()
    world.settle()
    assert v.simxGetJointPosition(two, two, v.simx_opmode_buffer) == (0, 2.0)
    assert caplog.text.count("failed and are ended") == 1


def test_a_pass_that_fails_stops_the_simulation_and_not_the_server(world, monkeypatch, caplog):
    cid = world.client()
    v.simxSynchronous(cid, True)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)

    def fail():
        raise FloatingPointError("no number")

    monkeypatch.setattr(world.simulation, "step", fail)
    assert v.simxSynchronousTrigger(cid) == v.simx_return_remote_error_flag
    assert world.simulation.state is SimulationState.STOPPED
    assert v.simxGetPingTime(cid)[0] == 0
    assert "no number" in caplog.text


def test_calls_of_a_client_that_never_said_hello_are_ignored(world):
    world.loop.service.queue.submit(
        "stranger", BatchWork(encode(Batch(0, 0, [Call(1, 0, 0, "simxStartSimulation", [])])))
    )
    world.settle()
    assert world.simulation.state is SimulationState.STOPPED


def test_a_lost_server_is_noticed_and_a_reconnection_counts_up(world, caplog):
    cid = world.client()
    v.simxGetJointPosition(cid, 3, v.simx_opmode_streaming)
    world.settle()
    assert v.simxGetConnectionId(cid) == 1
    transport = world.transports[cid]
    transport.lose()
    assert v.simxGetConnectionId(cid) == -1
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_buffer) == (1, 0.0)
    transport._connected = True  # a server is there again
    assert v.simxGetConnectionId(cid) == 2
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_blocking)[0] == 0
    assert "went away" in caplog.text
    assert "again" in caplog.text


def test_a_lost_server_has_no_state_to_tell(world):
    cid = world.client()
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state)[0] == 1
    world.transports[cid].lose()
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state) == (-1, 0)


def test_what_was_on_its_way_when_the_server_was_lost_is_not_taken_for_news_of_the_next(world):
    cid = world.client()
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    v.simxGetJointPosition(cid, 3, v.simx_opmode_oneshot)
    world.settle()
    transport = world.transports[cid]
    of_before = transport._deliveries.get_nowait()
    transport.lose()
    assert v.simxGetConnectionId(cid) == -1
    transport._connected = True
    assert v.simxGetConnectionId(cid) == 2
    transport.put_replies(of_before)
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_buffer) == (1, 0.0)
    assert v.simxGetInMessageInfo(cid, v.simx_headeroffset_server_state) == (-1, 0)


def test_a_loop_without_a_pause_runs_at_the_servers_pace_and_builds_no_backlog(world, monkeypatch):
    cid = world.client()
    transport = world.transports[cid]
    receive = transport.receive
    # The server answers only while the client waits.
    monkeypatch.setattr(transport, "receive", lambda timeout, **_: receive(timeout) if timeout > 0 else None)
    backlog = 0
    for value in range(1000):
        v.simxSetJointPosition(cid, 3, float(value), v.simx_opmode_oneshot)
        backlog = max(backlog, len(world.loop.service.queue))
    assert backlog <= MAX_UNANSWERED + 1
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_blocking) == (0, 999.0)


def test_without_reconnection_calls_answer_at_once_that_there_is_no_value(world):
    cid = world.client(may_reconnect=False)
    world.transports[cid].lose()
    assert v.simxGetConnectionId(cid) == -1
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_blocking) == (3, 0.0)
    assert v.simxGetJointPosition(cid, 3, v.simx_opmode_oneshot) == (1, 0.0)


class _Clock:
    now = 100.0

    def __call__(self):
        return self.now


def test_real_time_passes_come_one_step_apart_and_double_speed_in_half():
    for speed, gap in ((1.0, 0.05), (2.0, 0.025)):
        clock = _Clock()
        pacer = Pacer(speed, clock)
        assert pacer.seconds_left() == 0.0
        pacer.passed(0.05)
        assert pacer.seconds_left() == pytest.approx(gap)


def test_at_full_speed_the_next_pass_is_always_due():
    pacer = Pacer(math.inf, _Clock())
    pacer.passed(0.05)
    assert pacer.seconds_left() == 0.0


def test_a_simulation_that_cannot_keep_up_says_so_once_and_gives_the_lost_time_up(caplog):
    clock = _Clock()
    pacer = Pacer(1.0, clock)
    for _ in range(10):
        clock.now += 1.0
        pacer.passed(0.05)
    assert caplog.text.count("cannot keep up") == 1
    clock.now += 0.01
    pacer.passed(0.05)
    assert pacer.seconds_left() > 0
