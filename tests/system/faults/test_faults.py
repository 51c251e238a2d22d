"""Deaths, freezes and forks: what one process does to itself must not harm the others."""

import contextlib
import signal
import threading
from types import SimpleNamespace

import pytest
from plain_world import World
from processes import ROOT, give_way, read_line, running, spawn, wait_until

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.errors import ConnectionFailed
from simx_client.legacy import local
from simx_client.protocol.codec import encode
from simx_client.protocol.messages import PROTOCOL_VERSION, Greeting
from simx_client.protocol.zenoh import keys
from simx_client.transport.endpoints import ServerAddress
from simx_client.transport.zenoh import ZenohTransport
from simx_server.gateways.zenoh.link import ZenohLink
from simx_server.gateways.zenoh.posting import Care, Postman

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_connection_left")]

BLOCKING = v.simx_opmode_blocking


@contextlib.contextmanager
def plain_server():
    """A plain server's process and port."""
    with running(spawn(ROOT / "tests" / "support" / "worlds" / "plain_server.py")) as process:
        yield process, int(read_line(process))


@contextlib.contextmanager
def script(port, *lines):
    """A client's process, connected as client 0; the given lines are its program."""
    program = [
        "import sys; sys.path.insert(0, '.'); import simx_client as v",
        f"assert v.simxStart('127.0.0.1', {port}, True, True, 5000, 5) == 0",
        *lines,
    ]
    with running(spawn("-c", "\n".join(program))) as process:
        yield process


PICTURES = (
    "v.simxStartSimulation(0, v.simx_opmode_blocking)",
    "v.simxGetVisionSensorImage(0, 1, 0, v.simx_opmode_streaming)",
    "while v.simxGetVisionSensorImage(0, 1, 0, v.simx_opmode_buffer)[0]: pass",
    "print('ready', flush=True); sys.stdin.read()",
)
MEGABYTES = (
    "from simx_client.connection.clients import CLIENTS",
    "from simx_client.protocol.codec import encode",
    "from simx_client.protocol.messages import Batch, Call",
    "call = encode(Batch(0, 0, [Call(1, 0, 0, 'simxGetStringSignal', ['x'])]))",
    "for _ in range(300): CLIENTS.get(0)._transport.send(call)",
    "print('ready', flush=True); sys.stdin.read()",
)


@pytest.mark.parametrize("frozen", [1, 2])
def test_clients_that_freeze_while_images_are_sent_to_them_do_not_cut_off_the_others(frozen):
    with plain_server() as (_, port), contextlib.ExitStack() as stack:
        watcher = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
        for _ in range(frozen):
            process = stack.enter_context(script(port, *PICTURES))
            assert read_line(process).strip() == "ready"
            process.send_signal(signal.SIGSTOP)
        codes = set()

        def call():
            codes.add(v.simxGetPingTime(watcher)[0])
            give_way()

        assert wait_until(lambda: v.simxGetObjects(watcher, 0, BLOCKING)[1] == [0], 30.0, turn=call)
        assert codes <= {0}
        assert v.simxGetPingTime(watcher)[0] == 0
        assert v.simxGetConnectionId(watcher) == 1


def test_a_client_that_freezes_with_hundreds_of_answers_on_the_way_holds_the_others_up_only_shortly():
    with plain_server() as (_, port), script(port, *MEGABYTES) as process:
        watcher = v.simxStart("127.0.0.1", port, True, True, -3000, 5)
        assert read_line(process).strip() == "ready"
        process.send_signal(signal.SIGSTOP)
        assert v.simxGetPingTime(watcher)[0] == 0  # not before all those were executed
        assert v.simxGetConnectionId(watcher) == 1


@contextlib.contextmanager
def waiting_for_a_pass(port):
    """(client, other, the codes its trigger returned so far, its thread): a trigger waits for that of the other."""
    client, other = (v.simxStart(f"127.0.0.{n}", port, True, True, -60_000, 5) for n in (1, 2))
    for each in (client, other):
        v.simxSynchronous(each, True)
    v.simxStartSimulation(client, BLOCKING)
    codes = []
    thread = threading.Thread(target=lambda: codes.append(v.simxSynchronousTrigger(client)), daemon=True)
    thread.start()
    v.simxGetPingTime(other)
    yield client, other, codes, thread


def test_a_call_that_waits_when_its_server_is_killed_ends_before_its_time_out():
    with plain_server() as (process, port), waiting_for_a_pass(port) as (client, other, codes, thread):
        process.kill()
        thread.join(20)
        assert codes == [3]
        assert v.simxGetConnectionId(client) == -1
        assert wait_until(lambda: v.simxGetConnectionId(other) == -1, 2.0)  # a session of its own
        assert v.simxGetPingTime(other)[0] == 3


def test_a_call_that_waits_when_another_thread_finishes_its_client_ends_before_its_time_out():
    with plain_server() as (_, port), waiting_for_a_pass(port) as (client, other, codes, thread):
        finishing = threading.Thread(target=v.simxFinish, args=(client,), daemon=True)
        finishing.start()
        finishing.join(20)
        assert not finishing.is_alive()
        thread.join(20)
        assert codes == [3]
        assert wait_until(lambda: v.simxGetObjects(other, 0, BLOCKING) == (0, [0]), 5.0)


@pytest.mark.parametrize("once", [True, False])
def test_finishing_a_client_that_is_being_connected_in_the_background_leaves_no_thread_in_zenoh(once):
    with plain_server() as (_, port):
        for _ in range(5):
            assert v.simxStart("127.0.0.1", port, False, once, 5000, 5) == 0
            v.simxFinish(-1)
            assert "simx-connect" not in {thread.name for thread in threading.enumerate()}


@pytest.fixture
def transport():
    with plain_server() as (_, port):
        transport = ZenohTransport(ServerAddress.at("127.0.0.1", port), connect_timeout=5.0, retry=False)
        yield transport
        transport.close()


def test_an_image_that_comes_while_the_one_before_is_taken_is_the_newest(transport):
    class TakenWhenLookedAt(dict):
        def get(self, *arguments):
            found = super().get(*arguments)
            transport.images()  # the reader's thread, at the worst moment
            return found

    def picture(payload):
        content = SimpleNamespace(to_bytes=lambda: payload)
        return SimpleNamespace(key_expr="simx/realm/picture/client/1", payload=content)

    transport.new_images = TakenWhenLookedAt()
    for payload in (b"first", b"second"):
        transport._on_image(picture(payload))
    assert transport.images() == [b"second"]


def test_a_server_that_dies_right_after_its_welcome_is_not_taken_for_alive(transport, monkeypatch):
    def ask_and_lose(*arguments):
        welcome = ask(*arguments)
        transport._on_server(SimpleNamespace(kind=transport._zenoh.SampleKind.DELETE))
        return welcome

    transport.greet(5.0)
    ask = transport._ask
    monkeypatch.setattr(transport, "_ask", ask_and_lose)
    transport.greet(5.0)
    assert transport.was_lost
    assert not transport.is_connected


def test_a_client_whose_leaving_nobody_would_notice_is_not_taken_in(transport):
    session, port = transport._session, transport._asked_port
    watcher = v.simxStart("127.0.0.1", port, True, True, 5000, 5)
    realm = f"simx-{port}"
    greeting = encode(Greeting(PROTOCOL_VERSION, "ghost", "a ghost", port, PROTOCOL_VERSION))
    assert not [reply.ok for reply in session.get(keys.hello(realm), payload=greeting)]
    assert v.simxGetObjects(watcher, 0, BLOCKING) == (0, [0])
    transport.greet(5.0)
    assert v.simxGetObjects(watcher, 0, BLOCKING) == (0, [0, 1])
    transport.close()
    assert wait_until(lambda: v.simxGetObjects(watcher, 0, BLOCKING) == (0, [0]), 5.0)


def test_what_is_ready_for_a_client_that_has_gone_is_dropped_without_a_word(transport, caplog):
    postman = Postman(Care(), lambda _: None)
    link = ZenohLink(transport._zenoh, transport._session, "realm", "client", postman, lambda: None)
    link.close()
    link.put_replies(b"an answer")
    link.put_values(b"values")
    transport.close()
    link.put_image(1, b"a picture")
    assert not caplog.records


def _fork(*lines):
    """A program's lines that run these in a forked child and say how it ended."""
    body = "\n".join(f"    {line}" for line in lines)
    return (
        "import os, warnings; warnings.simplefilter('ignore')",
        f"child = os.fork()\nif not child:\n{body}\n    sys.exit(7)",
        "print('child ended with', os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)",
    )


def test_a_forked_child_leaves_its_parents_connection_alone():
    with plain_server() as (_, port):
        lines = _fork(
            "assert v.simxGetJointPosition(0, 1, v.simx_opmode_blocking) == (64, 0.0)",
            "assert v.simxFinish(-1) is None",
        )
        after = "print(v.simxGetJointPosition(0, 1, v.simx_opmode_blocking), flush=True); v.simxFinish(0)"
        with script(port, *lines, after, "print('finished', flush=True)") as process:
            assert read_line(process).strip() == "child ended with 7"
            assert read_line(process).strip() == "(0, 0.0)"
            assert read_line(process).strip() == "finished"
            assert process.wait(10) == 0


def test_a_child_forked_after_connecting_gets_minus_1_and_the_way_out():
    with plain_server() as (_, port):
        lines = _fork(
            "import logging; logging.basicConfig(stream=sys.stdout, format='%(message)s')",
            f"print(v.simxStart('127.0.0.1', {port}, True, True, 5000, 5), flush=True)",
        )
        with script(port, *lines) as process:
            assert "'spawn'" in read_line(process)
            assert read_line(process).strip() == "-1"
            assert read_line(process).strip() == "child ended with 7"


def test_a_program_may_connect_more_often_than_it_may_have_open_files():
    with plain_server() as (_, port):
        connect = f"v.simxStart('127.0.0.1', {port}, True, True, 5000, 5)"
        lines = (
            "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (150, 150))",
            f"v.simxFinish(0); print({{({connect}, v.simxFinish(0)) for _ in range(200)}}, flush=True)",
        )
        with script(port, *lines) as process:
            assert read_line(process).strip() == "{(0, None)}"


def test_a_program_that_may_make_no_shared_memory_connects_without():
    with plain_server() as (_, port):
        no_memory = (
            "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)",
            "v.simxFinish(0); resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))",
            f"print(v.simxStart('127.0.0.1', {port}, True, True, 5000, 5), flush=True)",
            "print(v.simxGetJointPosition(0, 1, v.simx_opmode_blocking), flush=True)",
        )
        with script(port, *no_memory) as process:
            assert [read_line(process).strip() for _ in range(2)] == ["0", "(0, 0.0)"]


def test_ctrl_c_while_connecting_leaves_no_client_behind(monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(local, "open_link", interrupted)
    with pytest.raises(KeyboardInterrupt):
        v.simxStart("127.0.0.1", 19997, True, True, 5000, 5)
    assert CLIENTS.get(0) is None


def test_a_start_that_fails_does_not_finish_the_client_that_has_its_id_by_now(monkeypatch):
    world = World()

    def meanwhile(*_, **__):
        v.simxFinish(-1)  # as another thread may
        assert world.client() == 0
        raise ConnectionFailed("nothing there")

    monkeypatch.setattr(local, "open_link", meanwhile)
    assert v.simxStart("127.0.0.1", 19997, True, True, 5000, 5) == -1
    assert v.simxGetJointPosition(0, 1, BLOCKING) == (0, 0.0)


def test_a_robot_that_is_collected_while_a_client_is_added_may_finish_its_own():
    class CollectsGarbage:
        works_after_fork = False

        @property
        def where(self):
            v.simxFinish(7)  # what a script's __del__ does
            return "here"

        def close(self, flush_timeout):
            pass

    for _ in range(2):  # the second one is compared with the first
        thread = threading.Thread(target=CLIENTS.add, args=(CollectsGarbage(),), daemon=True)
        thread.start()
        thread.join(10)
        assert not thread.is_alive()
