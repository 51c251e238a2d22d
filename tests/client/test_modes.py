"""The operation modes, over the in-process way: which calls are sent, where a result comes from."""

import pytest
from mode_world import GET, SET, cid, world

import simx_client as v
from simx_client.calls.marshalling import Marshal
from simx_client.calls.operation_modes import Modes
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.commands import BY_NAME
from simx_client.protocol.messages import Reply

__all__ = ["cid", "world"]


def test_the_first_client_id_is_0_and_again_after_finish_all(world):
    assert world.client() == 0
    assert world.client() == 1
    v.simxFinish(-1)
    assert world.client() == 0


def test_blocking_waits_for_its_own_reply(world, cid):
    world.simulation.joints[3] = 0.5
    assert GET(cid, 3, v.simx_opmode_blocking) == (0, 0.5)
    assert GET(cid, 3, v.simx_opmode_oneshot_wait) == (0, 0.5)


def test_blocking_leaves_nothing_in_the_inbox(cid):
    GET(cid, 3, v.simx_opmode_blocking)
    assert GET(cid, 3, v.simx_opmode_buffer) == (v.simx_return_novalue_flag, 0.0)


def test_oneshot_answers_with_the_previous_execution(world, cid):
    world.simulation.joints[3] = 1.0
    assert GET(cid, 3, v.simx_opmode_oneshot) == (1, 0.0)
    world.settle()
    world.simulation.joints[3] = 2.0
    assert GET(cid, 3, v.simx_opmode_oneshot) == (0, 1.0)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 2.0)


def test_a_oneshot_set_answers_1_first_and_then_the_earlier_status(world, cid):
    assert SET(cid, 3, 1.0, v.simx_opmode_oneshot) == 1
    world.settle()
    assert SET(cid, 3, 2.0, v.simx_opmode_oneshot) == 0


class Sets:
    """Oneshot sets of this many joints, without any server; the first has the id 1."""

    def __init__(self, count):
        self.modes, self._marshal, self._joints = (
            Modes(),
            Marshal(BY_NAME["simxSetJointPosition"]),
            range(count),
        )
        self._call(v.simx_opmode_oneshot)

    def _call(self, mode):
        return [self.modes.call(self._marshal, [joint, 0.0], mode) for joint in self._joints]

    def codes_after(self, *replies):
        self.modes.absorb_replies(list(replies))
        return self._call(v.simx_opmode_buffer)


def test_one_answer_may_be_that_to_several_sets():
    sets = Sets(4)
    assert sets.codes_after(Reply(1, 0, 150, [3])) == [0, 0, 0, 1]
    assert sets.modes.last_command_time_ms == 150
    assert sets.codes_after(Reply(4, 8, 150, ["why"])) == [0, 0, 0, 8]
    assert not sets.modes._asked


def test_a_server_that_answers_each_set_by_itself_is_understood():
    sets = Sets(3)
    assert sets.codes_after(*[Reply(call_id, 0, 150, []) for call_id in (1, 2, 3)]) == [0, 0, 0]
    assert not sets.modes._asked


@pytest.mark.parametrize(
    "follow",
    [
        lambda modes: modes.call(Marshal(BY_NAME["simxGetJointPosition"]), [1], v.simx_opmode_oneshot),
        lambda modes: modes.call(
            Marshal(BY_NAME["simxSetJointTargetPosition"]), [1, 0.0], v.simx_opmode_streaming
        ),
        lambda modes: modes.ask(Marshal(BY_NAME["simxStartSimulation"]), []),
    ],
    ids=("a read", "a stream", "a call that is waited for"),
)
def test_an_answer_to_several_sets_is_none_to_what_lies_among_them(follow):
    """Any count of a server."""
    sets = Sets(1)
    follow(sets.modes)
    assert sets.codes_after(Reply(1, 0, 150, [2])) == [0]
    assert list(sets.modes._asked) == [2]
    assert not sets.modes.is_answered()
    sets.modes.lose(arms_again=True)


def test_a_ping_ends_no_stream_whatever_its_number(world, cid):
    GET(cid, 1, v.simx_opmode_streaming)
    (session,) = world.loop.service.clients.sessions.values()
    world.settle()
    assert list(session.streams.by_id) == [1]
    v.simxGetPingTime(cid)
    world.simulation.joints[1] = 4.0
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.settle()
    assert GET(cid, 1, v.simx_opmode_buffer) == (0, 4.0)


@pytest.mark.parametrize(("count", "code"), [(2**40, 0), (0, 1), (-1, 1)])
def test_an_answer_to_more_or_fewer_sets_than_were_sent_does_no_harm(count, code):
    assert Sets(2).codes_after(Reply(1, 0, 150, [count])) == [code, code]


def test_the_first_streaming_call_has_no_value_and_buffer_then_has_the_newest(world, cid):
    world.simulation.joints[3] = 1.0
    assert GET(cid, 3, v.simx_opmode_streaming) == (1, 0.0)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 1.0)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.simulation.joints[3] = 7.0
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 7.0)
    assert GET(cid, 3, v.simx_opmode_streaming) == (0, 7.0)


def test_streaming_goes_on_while_the_simulation_is_stopped(world, cid):
    GET(cid, 3, v.simx_opmode_streaming)
    world.settle()
    world.simulation.joints[3] = 4.0
    world.loop.turn(max_wait=1.0)  # the idle pass
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 4.0)


def test_buffer_without_any_streaming_is_novalue_and_sends_nothing(world, cid):
    assert GET(cid, 3, v.simx_opmode_buffer) == (1, 0.0)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (1, 0.0)


def test_a_blocking_call_ends_the_stream_of_its_key(world, cid):
    GET(cid, 3, v.simx_opmode_streaming)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_blocking)[0] == 0
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (1, 0.0)
    assert not next(iter(world.loop.service.clients.sessions.values())).streams.by_id


def test_a_oneshot_call_ends_the_stream_and_its_value_stays(world, cid):
    GET(cid, 3, v.simx_opmode_streaming)
    world.settle()
    world.simulation.joints[3] = 1.5
    GET(cid, 3, v.simx_opmode_oneshot)
    world.settle()
    world.simulation.joints[3] = 9.0
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 1.5)


def test_discontinue_gives_the_last_value_once_more_and_then_none(world, cid):
    world.simulation.joints[3] = 2.5
    GET(cid, 3, v.simx_opmode_streaming)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_discontinue) == (0, 2.5)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (1, 0.0)
    assert not next(iter(world.loop.service.clients.sessions.values())).streams.by_id


def test_discontinue_of_what_is_not_streamed_is_harmless(world, cid):
    assert GET(cid, 3, v.simx_opmode_discontinue) == (1, 0.0)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_blocking)[0] == 0


def test_ending_a_stream_again_and_again_while_paused_is_sent_once_and_remembered_once(world, cid):
    GET(cid, 3, v.simx_opmode_streaming)
    world.settle()
    v.simxPauseCommunication(cid, True)
    for _ in range(5):
        GET(cid, 3, v.simx_opmode_discontinue)
    connection = CLIENTS.get(cid)
    assert connection is not None
    assert len(connection._modes._cancels) == 1
    v.simxPauseCommunication(cid, False)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (1, 0.0)
    assert not next(iter(world.loop.service.clients.sessions.values())).streams.by_id


@pytest.mark.parametrize(
    "mode",
    [v.simx_opmode_discontinue, v.simx_opmode_oneshot, v.simx_opmode_streaming, v.simx_opmode_blocking],
)
def test_a_stream_ended_while_paused_ends_whatever_is_called_next(world, mode):
    cid = world.client(timeout=0.0)
    SET(cid, 3, 1.0, v.simx_opmode_streaming)
    world.settle()
    v.simxPauseCommunication(cid, True)
    SET(cid, 3, 1.0, v.simx_opmode_discontinue)
    SET(cid, 3, 2.0, mode)
    v.simxPauseCommunication(cid, False)
    world.settle()
    (session,) = world.loop.service.clients.sessions.values()
    assert [s.arguments for s in session.streams.by_id.values()] == [[3, 2.0]] * (
        mode == v.simx_opmode_streaming
    )


def test_remove_forgets_the_value_and_says_whether_there_was_one(world, cid):
    GET(cid, 3, v.simx_opmode_oneshot)
    world.settle()
    GET(cid, 4, v.simx_opmode_buffer)
    assert GET(cid, 3, v.simx_opmode_remove) == (0, 0.0)
    assert GET(cid, 3, v.simx_opmode_remove) == (1, 0.0)
    assert GET(cid, 3, v.simx_opmode_buffer) == (1, 0.0)


@pytest.mark.parametrize("mode", [v.simx_opmode_streaming + 10, v.simx_opmode_streaming_split + 4000])
def test_a_rate_or_size_added_to_the_mode_is_accepted(world, cid, mode):
    world.simulation.joints[3] = 3.0
    assert GET(cid, 3, mode)[0] == 1
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 3.0)


def test_a_rate_spaces_the_executions(world, cid):
    GET(cid, 3, v.simx_opmode_streaming + 60_000)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.simulation.joints[3] = 8.0
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 0.0)


def test_oneshot_split_behaves_like_oneshot(world, cid):
    assert SET(cid, 3, 1.0, v.simx_opmode_oneshot_split + 100) == 1
    world.settle()
    assert world.simulation.joints[3] == 1.0


def test_a_streamed_set_goes_on_being_applied_until_replaced(world, cid):
    SET(cid, 3, 1.0, v.simx_opmode_streaming)
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    world.simulation.joints[3] = 0.0
    world.settle()
    assert world.simulation.joints[3] == 1.0
    SET(cid, 3, 2.0, v.simx_opmode_streaming)
    world.settle()
    world.settle()
    assert world.simulation.joints[3] == 2.0


def test_a_failing_stream_answers_8_and_recovers(world, cid):
    world.simulation.joints[3] = 1.5
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    assert GET(cid, 3, v.simx_opmode_streaming) == (1, 0.0)
    for removed, expected in ((set(), (0, 1.5)), ({3}, (8, 0.0)), (set(), (0, 1.5))):
        world.simulation.removed = removed
        world.settle()
        assert GET(cid, 3, v.simx_opmode_buffer) == expected


def test_get_and_clear_ends_its_stream_with_the_first_hit(world, cid):
    v.simxGetAndClearStringSignal(cid, "s", v.simx_opmode_streaming)
    world.settle()
    world.simulation.strings["s"] = b"hit"
    world.loop.turn(max_wait=1.0)
    world.settle()
    assert v.simxGetAndClearStringSignal(cid, "s", v.simx_opmode_buffer) == (0, bytearray(b"hit"))
    assert v.simxGetAndClearStringSignal(cid, "s", v.simx_opmode_buffer) == (1, bytearray())
    assert not next(iter(world.loop.service.clients.sessions.values())).streams.by_id


def test_read_string_stream_loses_nothing_and_gives_empty_data_between(world, cid):
    read = v.simxReadStringStream
    assert read(cid, "s", v.simx_opmode_streaming) == (1, bytearray())
    v.simxStartSimulation(cid, v.simx_opmode_blocking)
    for word in (b"a", b"b", b"c"):
        v.simxWriteStringStream(cid, "s", word, v.simx_opmode_oneshot)
        world.settle()
    world.settle()
    assert read(cid, "s", v.simx_opmode_buffer) == (0, bytearray(b"abc"))
    assert read(cid, "s", v.simx_opmode_buffer) == (0, bytearray())


def test_read_string_stream_refuses_blocking(cid):
    assert v.simxReadStringStream(cid, "s", v.simx_opmode_blocking) == (4, bytearray())


def test_query_sets_one_signal_and_returns_the_other(world, cid):
    answered = _answer_in_the_world(world)
    assert v.simxQuery(cid, "ask", b"1+1", "answer", 5000) == (0, bytearray(b"2"))
    answered()
    assert v.simxQuery(cid, "ask", b"1+1", "answer", 10)[0] == v.simx_return_timeout_flag


def _answer_in_the_world(world):
    """Answer signal 'ask' in the world, as a script in the scene would; returns how to stop it."""
    strings = world.simulation.strings

    class Answering(dict):
        def __setitem__(self, name, value):
            super().__setitem__(name, value)
            if name == "ask":
                super().__setitem__("answer", b"2")

    world.simulation.strings = Answering(strings)
    return lambda: setattr(world.simulation, "strings", {})


def test_paused_calls_arrive_together_in_order_and_only_the_last_of_a_key(world, cid):
    world.simulation.log.clear()
    assert v.simxPauseCommunication(cid, True) == 0
    SET(cid, 1, 1.0, v.simx_opmode_oneshot)
    SET(cid, 2, 2.0, v.simx_opmode_oneshot)
    SET(cid, 1, 3.0, v.simx_opmode_oneshot)
    world.settle()
    assert world.simulation.log == []
    assert v.simxPauseCommunication(cid, False) == 0
    v.simxGetPingTime(cid)
    assert world.simulation.log == [("set", 2, 2.0), ("set", 1, 3.0)]


def test_every_paused_status_message_is_kept(world, cid):
    v.simxPauseCommunication(cid, True)
    for _ in range(3):
        v.simxAddStatusbarMessage(cid, "again", v.simx_opmode_oneshot)
    v.simxPauseCommunication(cid, False)
    v.simxGetPingTime(cid)
    assert world.simulation.log.count(("status", "again")) == 3


def test_pauses_nest_and_a_resume_too_many_is_harmless(world, cid):
    v.simxPauseCommunication(cid, 1)
    v.simxPauseCommunication(cid, 1)
    v.simxPauseCommunication(cid, 0)
    SET(cid, 1, 1.0, v.simx_opmode_oneshot)
    world.settle()
    assert 1 not in world.simulation.joints
    v.simxPauseCommunication(cid, 0)
    v.simxPauseCommunication(cid, 0)
    world.settle()
    assert world.simulation.joints[1] == 1.0


def test_a_blocking_call_while_paused_times_out_at_once_and_is_sent_with_the_batch(world, cid):
    v.simxPauseCommunication(cid, True)
    assert GET(cid, 3, v.simx_opmode_blocking) == (3, 0.0)
    v.simxPauseCommunication(cid, False)
    world.settle()
    assert GET(cid, 3, v.simx_opmode_buffer) == (0, 0.0)


def test_oneshot_and_blocking_calls_keep_their_order(world, cid):
    for value in range(5):
        SET(cid, 3, float(value), v.simx_opmode_oneshot)
        assert GET(cid, 3, v.simx_opmode_blocking) == (0, float(value))


def test_results_are_new_lists_each_time_and_exact_types(world, cid):
    v.simxGetObjects(cid, 3, v.simx_opmode_streaming)
    world.settle()
    first = v.simxGetObjects(cid, 3, v.simx_opmode_buffer)
    first[1].append(99)
    assert v.simxGetObjects(cid, 3, v.simx_opmode_buffer) == (0, [0, 1, 2])
    assert type(first) is tuple
    assert type(first[0]) is int
    assert type(first[1]) is list
    assert all(type(n) is int for n in first[1])


def test_a_crash_in_a_handler_is_a_remote_error_and_the_server_goes_on(world, cid):
    call = v.simxCallScriptFunction
    arguments = ("RG2", 1, "crash", [], [], [], b"", v.simx_opmode_blocking)
    assert call(cid, *arguments) == (8, [], [], [], bytearray())
    assert "internal error" in v.simxGetLastErrors(cid, v.simx_opmode_blocking)[1][0]
    assert GET(cid, 3, v.simx_opmode_blocking)[0] == 0


def test_script_functions_take_and_return_what_old_scripts_use(cid):
    result = v.simxCallScriptFunction(
        cid, "RG2", v.sim_scripttype_childscript, "f", [1], [0.5], ["a"], "abc", v.simx_opmode_blocking
    )
    assert result == (0, [1], [0.5], ["a"], bytearray(b"abc"))
    assert type(result[4]) is bytearray


def test_a_blocking_script_call_returns_its_own_outputs_not_those_of_a_oneshot_before(cid):
    arguments = ("RG2", 1, "f")
    v.simxCallScriptFunction(cid, *arguments, [1], [], [], b"", v.simx_opmode_oneshot)
    assert v.simxCallScriptFunction(cid, *arguments, [2], [], [], b"", v.simx_opmode_blocking)[1] == [2]


def test_keyword_arguments_and_numpy_handles_work(world, cid):
    np = pytest.importorskip("numpy")
    handle = np.zeros((1, 1), dtype=int)[0]
    handle[:] = 3
    assert SET(clientID=cid, jointHandle=handle, position=0.5, operationMode=v.simx_opmode_blocking) == 0
    assert GET(cid, np.int64(3), operationMode=v.simx_opmode_blocking) == (0, 0.5)
    assert GET(np.int64(cid), handle, v.simx_opmode_blocking) == (0, 0.5)
    assert GET(np.array([cid]), handle, v.simx_opmode_blocking) == (0, 0.5)


def test_wrong_arguments_name_the_function_and_the_argument(cid):
    with pytest.raises(TypeError, match="simxGetJointPosition: jointHandle needs an integer, got str 'UR5'"):
        GET(cid, "UR5", v.simx_opmode_blocking)  # pyright: ignore[reportArgumentType] - is tested
