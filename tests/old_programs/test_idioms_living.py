"""How old scripts start, end, try again, crash, and share a simulator: nothing raises, nothing hangs."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest
from idiom_world import IdiomWorld, connect, handle, idiom_world, start_stepped

import simx_client as vrep

pytestmark = pytest.mark.slow


@pytest.fixture
def world() -> Iterator[IdiomWorld]:
    with idiom_world() as world:
        yield world


def test_finish_all_then_the_id_is_0_whatever_it_is_compared_with(world: IdiomWorld) -> None:
    vrep.simxFinish(-1)
    clientID = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
    assert clientID == 0
    assert clientID == vrep.simx_return_ok
    assert clientID > -1
    vrep.simxFinish(-1)
    assert vrep.simxStart("127.0.0.2", 19999, True, True, 5000, 5) == 0


@pytest.mark.parametrize(
    "arguments",
    [
        ("127.0.0.1", 19997, True, True, 5000, 5),
        ("127.0.0.1", 19997, True, False, 500, 0),
        ("127.0.0.1", 19999, True, True, -500000, 5),
        (b"127.0.0.1", 19997, 1, 1, 1000, 5),
    ],
)
def test_all_forms_of_start(world: IdiomWorld, arguments: tuple) -> None:
    assert vrep.simxStart(*arguments) == 0
    names = ("connectionAddress", "connectionPort", "waitUntilConnected", "doNotReconnectOnceDisconnected")
    names += ("timeOutInMs", "commThreadCycleInMs")
    vrep.simxFinish(-1)
    assert vrep.simxStart(**dict(zip(names, arguments, strict=True))) == 0


def test_start_in_a_loop_until_the_simulator_is_there(world: IdiomWorld) -> None:
    world.ports.clear()
    tries = 0
    while True:
        clientID = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
        if clientID > -1:
            break
        tries += 1
        if tries == 3:
            world.ports.append(19997)
    assert (tries, clientID) == (3, 0)


def test_ping_then_finish_delivers_the_last_oneshot(world: IdiomWorld) -> None:
    clientID = connect()
    cube = handle(clientID, "cube")
    vrep.simxSetObjectPosition(clientID, cube, -1, (2, 2, 0.1), vrep.simx_opmode_oneshot)
    vrep.simxGetPingTime(clientID)
    vrep.simxFinish(clientID)
    clientID = connect()
    _, position = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_blocking)
    assert position == pytest.approx([2, 2, 0.1])


def test_calls_after_finish_and_a_second_finish_only_answer_64(world: IdiomWorld) -> None:
    clientID = connect()
    shoulder = handle(clientID, "shoulder")
    vrep.simxFinish(clientID)
    assert vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking) == (64, 0.0)
    assert vrep.simxStopSimulation(clientID, vrep.simx_opmode_oneshot_wait) == 64
    assert vrep.simxGetConnectionId(clientID) == -1
    vrep.simxGetPingTime(clientID)
    vrep.simxFinish(clientID)
    vrep.simxFinish(-1)


def test_everything_with_the_id_of_a_failed_start_only_answers_64(world: IdiomWorld) -> None:
    world.ports.clear()
    clientID = vrep.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
    assert clientID == -1
    assert vrep.simxGetObjectHandle(clientID, "cube", vrep.simx_opmode_blocking) == (64, 0)
    assert vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot) == 64
    vrep.simxFinish(clientID)


def test_the_loop_over_the_connection_id_ends_with_the_server(world: IdiomWorld) -> None:
    clientID = connect()
    rounds = 0
    while vrep.simxGetConnectionId(clientID) != -1:
        rounds += 1
        vrep.simxGetObjectPosition(clientID, 1, -1, vrep.simx_opmode_oneshot)
        if rounds == 5:
            world.transports[-1].lose()
        assert rounds < 10
    assert rounds == 5


def test_stop_in_a_loop_until_the_code_is_0(world: IdiomWorld) -> None:
    clientID = connect()
    vrep.simxStartSimulation(clientID, vrep.simx_opmode_oneshot_wait)
    tries = 0
    while vrep.simxStopSimulation(clientID, vrep.simx_opmode_oneshot):
        tries += 1
        assert tries < 10
        world.settle(1)
    assert tries == 1


def test_the_poll_for_really_stopped(world: IdiomWorld) -> None:
    clientID = connect()
    vrep.simxStartSimulation(clientID, vrep.simx_opmode_blocking)
    vrep.simxStopSimulation(clientID, vrep.simx_opmode_blocking)
    for _ in range(10):
        vrep.simxGetBooleanParameter(clientID, vrep.sim_boolparam_headless, vrep.simx_opmode_blocking)
        code, state = vrep.simxGetInMessageInfo(clientID, vrep.simx_headeroffset_server_state)
        assert code == 1
        if state & 1 == 0:
            break
    else:
        pytest.fail("it never stopped")


def test_stop_and_start_is_the_reset_button(world: IdiomWorld) -> None:
    clientID = connect()
    shoulder, cube = handle(clientID, "shoulder"), handle(clientID, "cube")
    for _ in range(2):
        start_stepped(clientID)
        assert vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1] == 0.0
        vrep.simxSetJointTargetVelocity(clientID, shoulder, 2.0, vrep.simx_opmode_oneshot)
        vrep.simxSetObjectPosition(clientID, cube, -1, (3, 3, 1), vrep.simx_opmode_oneshot)
        for _ in range(10):
            vrep.simxSynchronousTrigger(clientID)
        assert vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1] > 0.5
        vrep.simxStopSimulation(clientID, vrep.simx_opmode_blocking)
        _, position = vrep.simxGetObjectPosition(clientID, cube, -1, vrep.simx_opmode_blocking)
        assert position == pytest.approx([2, -1, 0.0999], abs=1e-3)
    assert handle(clientID, "shoulder") == shoulder


def test_a_program_that_vanishes_while_stepping_leaves_a_simulator_for_the_next(world: IdiomWorld) -> None:
    first = connect()
    start_stepped(first)
    vrep.simxGetObjectPosition(first, handle(first, "cube"), -1, vrep.simx_opmode_streaming)
    world.transports[-1].lose()  # sys.exit() without simxFinish, or a crash
    assert world.loop.service.clients.sessions == {}
    clientID = connect()
    assert clientID == 0
    vrep.simxStopSimulation(clientID, vrep.simx_opmode_blocking)
    start_stepped(clientID)
    assert vrep.simxGetLastCmdTime(clientID) == 50


def test_two_ids_in_one_program_one_to_start_and_one_to_drive(world: IdiomWorld) -> None:
    vrep.simxFinish(-1)
    starter = vrep.simxStart("127.0.0.1", 19997, True, True, 500, 5)
    vrep.simxStartSimulation(starter, vrep.simx_opmode_oneshot_wait)
    driver = vrep.simxStart("127.0.0.1", 19999, True, True, 500, 5)
    assert (starter, driver) == (0, 1)
    elbow = handle(driver, "elbow")
    assert elbow == handle(starter, "elbow")
    vrep.simxSetIntegerSignal(starter, "UR5READY", 1, vrep.simx_opmode_blocking)
    assert vrep.simxGetIntegerSignal(driver, "UR5READY", vrep.simx_opmode_blocking) == (0, 1)
    vrep.simxFinish(starter)
    assert vrep.simxGetConnectionId(starter) == -1
    assert vrep.simxSetJointTargetPosition(driver, elbow, 0.5, vrep.simx_opmode_blocking) == 0


def test_a_thread_per_joint_over_one_id() -> None:
    """And the main thread waits with its own call; each gets its own answer."""
    with idiom_world(own_thread=True):
        clientID = connect()
        names = ["shoulder", "elbow", "rail", "cube", "crate", "target"]
        handles = {name: handle(clientID, name) for name in names}
        wrong: list[str] = []

        def work(name: str) -> None:
            for _ in range(40):
                if handle(clientID, name) != handles[name]:
                    wrong.append(name)
                vrep.simxGetObjectPosition(clientID, handles[name], -1, vrep.simx_opmode_streaming)
                vrep.simxGetObjectPosition(clientID, handles[name], -1, vrep.simx_opmode_buffer)

        threads = [threading.Thread(target=work, args=(name,)) for name in names]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            assert vrep.simxGetPingTime(clientID)[0] == 0
        assert wrong == []


def test_a_worker_reads_while_the_main_thread_steps() -> None:
    with idiom_world(own_thread=True):
        clientID = connect()
        start_stepped(clientID)
        shoulder = handle(clientID, "shoulder")
        vrep.simxSetJointTargetVelocity(clientID, shoulder, 1.0, vrep.simx_opmode_oneshot)
        seen: list[float] = []
        done = threading.Event()

        def watch() -> None:
            while not done.is_set():
                seen.append(vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1])

        worker = threading.Thread(target=watch)
        worker.start()
        for _ in range(40):
            assert vrep.simxSynchronousTrigger(clientID) == 0
        done.set()
        worker.join(10)
        assert seen == sorted(seen)
        assert vrep.simxGetJointPosition(clientID, shoulder, vrep.simx_opmode_blocking)[1] > 1.5


def test_polling_for_a_signal_that_comes_later_does_not_fill_the_log(
    world: IdiomWorld, caplog: pytest.LogCaptureFixture
) -> None:
    clientID = connect()
    with caplog.at_level("INFO"):
        for _ in range(20):
            assert vrep.simxGetIntegerSignal(clientID, "ready", vrep.simx_opmode_blocking) == (8, 0)
    assert sum("no integer signal 'ready'" in record.message for record in caplog.records) == 2
    vrep.simxSetIntegerSignal(clientID, "ready", 1, vrep.simx_opmode_oneshot)
    assert vrep.simxGetIntegerSignal(clientID, "ready", vrep.simx_opmode_blocking) == (0, 1)
