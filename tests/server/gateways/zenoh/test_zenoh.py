"""Client and server as real processes over real Zenoh: connecting, dying, coming back."""

import contextlib
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest
from processes import ROOT, finished, read_line, running, server, spawn, wait_until

import simx_client as v
from simx_client.errors import NoAnswer
from simx_client.transport import zenoh as transport
from simx_client.transport.diagnosis import diagnose

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_connection_left")]

BLOCKING = v.simx_opmode_blocking

TIMEOUT = 5.0
"""Seconds: that of simxStart here, and that of a blocking call."""

BEFORE_THE_LEASE = 3.5
"""Seconds: a peer whose process has ended is noticed at once, a frozen one after the lease of 4 s."""


@pytest.fixture(scope="module")
def pendulum(scene):
    with server(scene, ports=(0, 0)) as process:
        yield process


def _connect(port, **more):
    options = {"timeOutInMs": round(1000 * TIMEOUT), "doNotReconnectOnceDisconnected": True, **more}
    return v.simxStart(
        connectionAddress=options.pop("address", "127.0.0.1"),
        connectionPort=port,
        waitUntilConnected=options.pop("wait", True),
        commThreadCycleInMs=5,
        **options,
    )


def _greet_all(listener):
    """Say hello to everyone, as an SMTP server does, until the listener is shut down."""
    with contextlib.suppress(OSError):
        while True:
            with listener.accept()[0] as caller:
                caller.sendall(b"220 hello there, this is another program\r\n")


def _free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def test_a_script_connects_asks_and_leaves(pendulum):
    cid = _connect(pendulum.port)
    assert cid == 0
    assert v.simxGetConnectionId(cid) == 1
    code, handle = v.simxGetObjectHandle(cid, "hinge", BLOCKING)
    assert code == 0
    assert handle > 0
    assert v.simxGetJointPosition(cid, handle, BLOCKING) == (0, 0.0)
    code, milliseconds = v.simxGetPingTime(cid)
    assert code == 0
    assert milliseconds < 1000 * TIMEOUT
    assert v.simxFinish(cid) is None
    assert v.simxGetJointPosition(cid, handle, BLOCKING) == (64, 0.0)
    assert _connect(pendulum.port) == 0


@pytest.mark.parametrize("address", ["localhost", "127.0.0.2", b"127.0.0.1"])
def test_host_names_other_loopback_addresses_and_bytes_connect(pendulum, address):
    assert _connect(pendulum.port, address=address) == 0


def test_a_negative_port_is_the_port_of_its_absolute_value(pendulum):
    """V-REP's shared memory."""
    assert _connect(-pendulum.port) == 0
    assert _connect(pendulum.port) == -1, "the same place twice"


def test_both_ports_lead_to_the_same_simulation(pendulum):
    one, two = _connect(pendulum.ports[0]), _connect(pendulum.ports[1])
    assert (one, two) == (0, 1)
    v.simxSetIntegerSignal(one, "hello", 42, BLOCKING)
    assert v.simxGetIntegerSignal(two, "hello", BLOCKING) == (0, 42)


def test_the_same_address_and_port_twice_is_minus_1_and_says_why(pendulum, caplog):
    assert _connect(pendulum.port) == 0
    assert _connect(pendulum.port) == -1
    assert "client 0 is connected to" in caplog.text
    assert "simxFinish" in caplog.text


def test_nothing_there_is_minus_1_at_once_with_the_way_out(caplog):
    port = _free_port()
    began = time.monotonic()
    assert _connect(port) == -1
    assert time.monotonic() - began < TIMEOUT
    assert f"nothing listens at 127.0.0.1:{port}" in caplog.text
    assert f"simx-server --port {port}" in caplog.text


def test_another_program_on_the_port_is_named_as_such(caplog):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        greeting = threading.Thread(target=_greet_all, args=(other,), daemon=True)
        greeting.start()
        assert _connect(other.getsockname()[1], timeOutInMs=300) == -1
        other.shutdown(socket.SHUT_RDWR)
        greeting.join(10)
    assert "does not speak Zenoh" in caplog.text


def test_a_port_that_accepts_and_keeps_silent_may_be_a_slow_server(caplog):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        assert _connect(other.getsockname()[1], timeOutInMs=300) == -1
    assert "did not answer in time" in caplog.text
    assert "a simx-server that is busy" in caplog.text
    assert "nothing listens" not in caplog.text


def test_a_frozen_server_is_not_called_missing_and_one_attempt_lasts_until_it_answers(
    scene, caplog, monkeypatch
):
    with server(scene) as process:
        process.process.send_signal(signal.SIGSTOP)
        assert _connect(process.port, timeOutInMs=300) == -1
        assert (
            f"the simx-server at 127.0.0.1:{process.port} is there but did not answer in time" in caplog.text
        )
        reasons = []

        def wake_after(place, deadline):
            reasons.append(diagnose(place, deadline))
            process.process.send_signal(signal.SIGCONT)
            return reasons[-1]

        monkeypatch.setattr(transport, "diagnose", wake_after)
        assert _connect(process.port, timeOutInMs=30_000) == 0
        assert [type(each) for each in reasons] == [NoAnswer]


def test_an_unknown_host_and_a_wrong_port_are_minus_1_with_a_reason(caplog):
    assert _connect(19997, address="no-such-host.invalid", timeOutInMs=200) == -1
    assert _connect(-70000) == -1
    assert "not known" in caplog.text
    assert "1..65535" in caplog.text


def test_a_retrying_start_finds_a_server_that_comes_later(scene):
    port = _free_port()
    waiting = (
        "import sys; sys.path.insert(0, '.'); import simx_client as v;"
        f"print('trying', flush=True);"
        f"print(v.simxStart('127.0.0.1', {port}, True, False, 20000, 5), flush=True)"
    )
    with running(spawn("-c", waiting)) as client:
        assert read_line(client).strip() == "trying"
        with server(scene, ports=(port,)):
            assert read_line(client).strip() == "0"


def test_a_connection_made_in_the_background_is_made_again_too(scene):
    port = _free_port()
    cid = _connect(port, wait=False, doNotReconnectOnceDisconnected=False)
    for times in (1, 2):
        with server(scene, ports=(port,)) as process:
            assert wait_until(lambda times=times: v.simxGetConnectionId(cid) == times, 10.0)
            process.kill()
        assert wait_until(lambda: v.simxGetConnectionId(cid) == -1, 5.0)


def test_without_waiting_the_id_comes_at_once_and_the_connection_in_the_background(pendulum):
    cid = _connect(pendulum.port, wait=False)
    assert cid == 0
    assert wait_until(lambda: v.simxGetConnectionId(cid) == 1, 5.0)
    assert v.simxGetObjectHandle(cid, "hinge", BLOCKING)[0] == 0


@pytest.mark.parametrize("once", [True, False])
def test_a_blocking_call_waits_for_the_connection_in_the_background(pendulum, once):
    cid = _connect(pendulum.port, wait=False, doNotReconnectOnceDisconnected=once)
    assert v.simxGetObjectHandle(cid, "hinge", BLOCKING)[0] == 0
    assert v.simxGetConnectionId(cid) == 1


def test_a_blocking_call_does_not_wait_for_an_only_attempt_that_failed(caplog):
    cid = _connect(_free_port(), wait=False, doNotReconnectOnceDisconnected=True)
    assert wait_until(lambda: "nothing listens" in caplog.text, 5.0)
    assert v.simxGetObjectHandle(cid, "hinge", BLOCKING) == (3, 0)


def test_what_was_called_before_the_connection_came_is_sent_by_itself(pendulum):
    watcher = _connect(pendulum.port)
    cid = _connect(pendulum.port, address="127.0.0.2", wait=False)
    assert v.simxSetIntegerSignal(cid, "early", 5, v.simx_opmode_oneshot) == 1
    assert wait_until(lambda: v.simxGetIntegerSignal(watcher, "early", BLOCKING) == (0, 5), 5.0)


def test_streams_reach_the_client(pendulum):
    cid = _connect(pendulum.port)
    _, handle = v.simxGetObjectHandle(cid, "hinge", BLOCKING)
    assert v.simxGetJointPosition(cid, handle, v.simx_opmode_streaming) == (1, 0.0)
    assert wait_until(lambda: v.simxGetJointPosition(cid, handle, v.simx_opmode_buffer)[0] == 0, 2.0)


def test_a_killed_server_is_noticed_and_a_new_one_is_found_again(scene):
    port = _free_port()
    with server(scene, ports=(port,)) as first:
        cid = _connect(port, doNotReconnectOnceDisconnected=False)
        _, handle = v.simxGetObjectHandle(cid, "hinge", BLOCKING)
        first.kill()
        assert wait_until(lambda: v.simxGetConnectionId(cid) == -1, BEFORE_THE_LEASE)
        assert v.simxGetJointPosition(cid, handle, v.simx_opmode_buffer)[0] == 1
    with server(scene, ports=(port,)):
        assert wait_until(lambda: v.simxGetConnectionId(cid) == 2, 5.0)
        assert v.simxGetJointPosition(cid, handle, BLOCKING)[0] == 0


def test_a_server_that_freezes_during_a_blocking_call_does_not_hang_the_client(scene):
    with server(scene) as process:
        cid = _connect(process.port)
        process.process.send_signal(signal.SIGSTOP)
        began = time.monotonic()
        assert v.simxGetObjectHandle(cid, "hinge", BLOCKING)[0] & v.simx_return_timeout_flag
        assert time.monotonic() - began < 2 * TIMEOUT
        process.kill()
    with server(scene) as process:
        assert _connect(process.port) >= 0


def test_a_killed_client_frees_its_stepped_mode_and_its_streams(scene):
    with server(scene) as process:
        stepping = (
            "import sys; sys.path.insert(0, '.'); import simx_client as v;"
            f"c = v.simxStart('127.0.0.1', {process.port}, True, True, 5000, 5);"
            "v.simxSynchronous(c, True); v.simxStartSimulation(c, v.simx_opmode_blocking);"
            "v.simxGetIntegerParameter(c, 1, v.simx_opmode_streaming); v.simxGetPingTime(c);"
            "print('stepping', flush=True); sys.stdin.read()"
        )
        watcher = _connect(process.port)
        waiting = v.sim_boolparam_waiting_for_trigger
        with running(
            subprocess.Popen(
                [sys.executable, "-c", stepping],
                cwd=ROOT,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
        ) as client:
            assert read_line(client).strip() == "stepping"
            assert v.simxGetBooleanParameter(watcher, waiting, BLOCKING) == (0, True)
            client.kill()
            assert wait_until(
                lambda: v.simxGetBooleanParameter(watcher, waiting, BLOCKING) == (0, False), BEFORE_THE_LEASE
            )


def test_sigterm_and_sigint_end_the_server_cleanly_within_five_seconds(scene):
    for number in (signal.SIGTERM, signal.SIGINT):
        with server(scene, "--start") as process:
            cid = _connect(process.port)
            process.process.send_signal(number)
            assert process.process.wait(5) == 0
            assert wait_until(lambda cid=cid: v.simxGetConnectionId(cid) == -1, BEFORE_THE_LEASE)
            v.simxFinish(-1)


def test_a_port_that_is_taken_is_a_clear_error_with_the_way_out(scene):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        done = finished("-m", "simx_server", scene, "--port", port)
    assert done.returncode == 1
    assert f"port {port} is taken" in done.stderr
    assert "--port" in done.stderr
    assert done.stdout == ""


def test_the_ready_line_names_endpoints_realm_and_scene_and_is_all_of_stdout(scene):
    with server(scene, "--realm", "lab-7", "--duration", "0.1") as process:
        assert f"tcp/127.0.0.1:{process.port}" in process.ready
        assert "realm=lab-7" in process.ready
        assert "scene=pendulum" in process.ready
        assert process.process.wait(10) == 0
        assert process.process.stdout is not None
        assert process.process.stdout.read() == ""


def test_quit_after_stop_ends_the_server_when_a_client_stops_the_simulation(scene):
    with server(scene, "--start", "--quit-after-stop") as process:
        cid = _connect(process.port)
        v.simxStopSimulation(cid, BLOCKING)
        assert process.process.wait(5) == 0


def test_an_unfinished_client_that_exits_does_not_hang(pendulum):
    script = (
        "import sys; sys.path.insert(0, '.'); import simx_client as v;"
        f"c = v.simxStart('127.0.0.1', {pendulum.port}, True, True, 5000, 5);"
        "v.simxGetIntegerParameter(c, 1, v.simx_opmode_streaming);"
        "v.simxSetIntegerSignal(c, 'last', 7, v.simx_opmode_oneshot); sys.exit(3)"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, timeout=20)
    assert done.returncode == 3
    cid = _connect(pendulum.port)
    assert v.simxGetIntegerSignal(cid, "last", BLOCKING) == (0, 7)


def test_an_idle_loop_until_the_server_ends_is_left(scene):
    with server(scene, "--duration", "0.3") as process:
        cid = _connect(process.port)
        assert wait_until(lambda: v.simxGetConnectionId(cid) == -1, 5.0)


@pytest.mark.parametrize(
    ("flags", "text"),
    [
        (["--config", "{folder}/bad.json5"], "is no Zenoh configuration: line 1, column 1"),
        (["--listen", "carrier-pigeon/1.2.3.4:5"], "not supported for carrier-pigeon"),
    ],
)
def test_what_zenoh_cannot_use_is_said_in_one_line(scene, tmp_path, flags, text):
    (tmp_path / "bad.json5").write_text("not json5 {")
    flags = [flag.format(folder=tmp_path) for flag in flags]
    done = finished("-m", "simx_server", scene, "--port", 0, *flags)
    assert done.returncode == 1
    (line,) = [line for line in done.stderr.splitlines() if "ERROR" in line]
    assert text in line
    assert ".rs:" not in done.stderr


def test_a_negative_time_out_is_that_of_blocking_calls(scene):
    with server(scene) as process:
        cid = _connect(process.port, timeOutInMs=-300)
        assert v.simxGetObjectHandle(cid, "hinge", BLOCKING)[0] == 0
        process.process.send_signal(signal.SIGSTOP)
        began = time.monotonic()
        code, handle = v.simxGetObjectHandle(cid, "hinge", BLOCKING)
        waited = time.monotonic() - began
        process.process.send_signal(signal.SIGCONT)
        assert (code, handle) == (v.simx_return_timeout_flag | v.simx_return_novalue_flag, 0)
        assert 0.3 <= waited < TIMEOUT
        # The late reply waits in the inbox for a call in buffer mode.
        assert wait_until(lambda: v.simxGetObjectHandle(cid, "hinge", v.simx_opmode_buffer)[0] == 0, 5.0)
        assert v.simxGetObjectHandle(cid, "hinge", BLOCKING)[0] == 0


def test_ctrl_c_ends_a_blocking_call_and_the_connection_is_still_good(scene):
    with server(scene) as process:
        interrupted = (
            "import sys; sys.path.insert(0, '.'); import simx_client as v;"
            f"c = v.simxStart('127.0.0.1', {process.port}, True, True, 20000, 5)\n"
            "v.simxSynchronous(c, True); v.simxStartSimulation(c, v.simx_opmode_blocking)\n"
            "try:\n"
            "    print('stepping', flush=True)\n"
            "    while True: v.simxGetPingTime(c)\n"
            "except KeyboardInterrupt: pass\n"
            "print(v.simxGetPingTime(c)[0], v.simxSynchronousTrigger(c), flush=True)\n"
        )
        with running(spawn("-c", interrupted)) as client:
            assert read_line(client).strip() == "stepping"
            client.send_signal(signal.SIGINT)
            assert read_line(client).strip() == "0 0"
            assert client.wait(10) == 0
