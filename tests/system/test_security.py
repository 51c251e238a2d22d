"""Access and rights of clients: the recipes of docs/operators/security.md, run as they stand there."""

from __future__ import annotations

import re
import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from processes import PENDULUM, ROOT, ServerProcess, server
from real_world import BLOCKING
from routers import router

import simx_client as v
from simx_client.connection.clients import CLIENTS
from simx_client.connection.discovery import find_servers, measure_servers
from simx_client.protocol.codec import encode
from simx_client.protocol.commands import ANSWERED
from simx_client.protocol.messages import Batch, Call
from simx_client.protocol.zenoh import keys, link

pytestmark = pytest.mark.slow

REMOTE_ERROR = v.simx_return_remote_error_flag
TIMEOUT = 5000
CHANGING_READERS = {"simxGetAndClearStringSignal", "simxReadStringStream", "simxGetUIEventButton"}

needs_openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="certificates are made by openssl")


@pytest.fixture(scope="module")
def recipes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files of the page, certificates among them."""
    folder = tmp_path_factory.mktemp("simx")
    page = (ROOT / "docs" / "operators" / "security.md").read_text().replace("/etc/simx", str(folder))
    blocks = re.findall(r"^```(?:sh|json5|text) (\S+)\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 12
    for name, text in blocks:
        (folder / name).write_text(text)
    done = subprocess.run(["sh", "-e", folder / "certificates"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    (folder / "pendulum.xml").write_text(PENDULUM)
    return folder


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Guarded:
    """A server behind one of the recipes, and ways to come to it."""

    def __init__(self, process: ServerProcess, endpoint: str, folder: Path, monkeypatch: Any) -> None:
        self.process, self.endpoint = process, endpoint
        self._folder, self._environment = folder, monkeypatch
        self._comes = 0

    def come(self, config: str | None, *, endpoint: str | None = None, role: str = "") -> int:
        """A client with one of the files of the page; -1 when it does not get in.

        Args:
            endpoint: instead of the one of TLS; an empty one is the loopback port, as a script has it.
        """
        endpoint = self.endpoint if endpoint is None else endpoint
        self._set("SIMX_CONNECT", endpoint)
        self._set("SIMX_CONFIG", str(self._folder / config) if config else "")
        self._set("SIMX_ROLE", role)
        # One process may come to a port once. Where the variable leads, the port does not matter.
        self._comes += 1
        port = self._comes if endpoint else self.process.port
        return v.simxStart("127.0.0.1", port, True, True, TIMEOUT, 5)

    def _set(self, variable: str, value: str) -> None:
        self._environment.setenv(variable, value)


Guard = Callable[[str], Guarded]


@pytest.fixture
def guard(recipes: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Guard]:
    """Starts a server with one of the files of the page."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    opened: list[Any] = []

    def start(config: str) -> Guarded:
        opened.append(server(recipes / "pendulum.xml", "--listen", endpoint, "--config", recipes / config))
        return Guarded(opened[-1].__enter__(), endpoint, recipes, monkeypatch)

    yield start
    v.simxFinish(-1)
    for each in opened:
        each.__exit__(None, None, None)


def hinge(client: int) -> int:
    code, handle = v.simxGetObjectHandle(client, "hinge", BLOCKING)
    assert code == 0
    return handle


def changed(recipes: Path, name: str, old: str, new: str) -> str:
    """A variant of one of the files; gives its name."""
    text = (recipes / name).read_text()
    assert old in text
    (recipes / f"changed-{name}").write_text(text.replace(old, new))
    return f"changed-{name}"


# --- TLS ------------------------------------------------------------------------------------------


@needs_openssl
def test_tls_lets_in_who_knows_the_authority_and_nobody_else(guard: Guard, recipes: Path, caplog) -> None:
    place = guard("tls-server.json5")
    inside = place.come("tls-client.json5")
    assert hinge(inside)
    began = time.monotonic()
    assert place.come(None) == -1
    assert "SIMX_CONFIG is not set" in caplog.text
    assert place.come(None, endpoint=place.endpoint.replace("tls/", "tcp/")) == -1
    caplog.clear()
    # another authority of the same name
    subprocess.run(
        [
            *(
                "openssl",
                "req",
                "-x509",
                "-newkey",
                "ec",
                "-pkeyopt",
                "ec_paramgen_curve:prime256v1",
                "-nodes",
            ),
            *("-subj", "/CN=simx authority", "-keyout", recipes / "other.key", "-out", recipes / "other.pem"),
        ],
        check=True,
        capture_output=True,
    )
    assert place.come(changed(recipes, "tls-client.json5", "ca.pem", "other.pem")) == -1
    assert "refused TLS or the login" in caplog.text
    assert time.monotonic() - began < 3 * TIMEOUT / 1000
    assert hinge(inside)
    assert v.simxGetConnectionId(inside) == 1


@needs_openssl
def test_plain_script_at_a_port_of_tls_is_told_so(guard: Guard, monkeypatch, caplog) -> None:
    place = guard("tls-server.json5")
    port = int(place.endpoint.rpartition(":")[2])
    assert v.simxStart("127.0.0.1", port, True, True, TIMEOUT, 5) == -1
    assert f"wants TLS: SIMX_CONNECT=tls/127.0.0.1:{port}" in caplog.text


@needs_openssl
def test_servers_behind_tls_are_listed(guard: Guard, recipes: Path, monkeypatch) -> None:
    place = guard("mtls-server.json5")
    assert [one.endpoint for one in find_servers([place.endpoint])[1]] == [place.endpoint]
    monkeypatch.setenv("SIMX_CONFIG", str(recipes / "mtls-client.json5"))
    ((found,), unreachable) = find_servers([place.endpoint])
    assert unreachable == []
    assert found.status is not None
    assert found.status.scene == "pendulum"


@needs_openssl
def test_mutual_tls_refuses_who_has_no_certificate(guard: Guard, caplog) -> None:
    place = guard("mtls-server.json5")
    inside = place.come("mtls-client.json5")
    assert hinge(inside)
    assert place.come("tls-client.json5") == -1
    assert "check user, password and certificates in" in caplog.text
    assert hinge(inside)
    assert v.simxGetConnectionId(inside) == 1
    assert hinge(place.come(None, endpoint=""))  # the loopback port stays plain


# --- user and password ----------------------------------------------------------------------------


@needs_openssl
@pytest.mark.parametrize("by", ["tls", "loopback"])
def test_wrong_password_is_refused_in_time_and_said(guard: Guard, recipes: Path, caplog, by: str) -> None:
    place = guard("password-server.json5")
    endpoint = None if by == "tls" else ""
    inside = place.come("password-client.json5")
    assert hinge(inside)
    for old, new in (("correct horse", "wrong horse"), ('"teacher"', '"stranger"')):
        caplog.clear()
        began = time.monotonic()
        assert place.come(changed(recipes, "password-client.json5", old, new), endpoint=endpoint) == -1
        assert time.monotonic() - began < TIMEOUT / 1000
        assert "the login" in caplog.text
        assert "changed-password-client.json5 (SIMX_CONFIG)" in caplog.text
    caplog.clear()
    assert place.come(None, endpoint="") == -1
    assert "speaks Zenoh but refused the login; SIMX_CONFIG is not set" in caplog.text
    began = time.monotonic()  # a client that keeps trying, too
    assert v.simxStart("127.0.0.1", place.process.port, True, False, 600, 5) == -1
    assert time.monotonic() - began < TIMEOUT / 1000
    assert hinge(inside)
    assert v.simxGetConnectionId(inside) == 1


@needs_openssl
def test_login_in_a_variable_is_enough_and_replaces_that_of_the_file(
    guard: Guard, recipes: Path, monkeypatch, caplog
) -> None:
    place = guard("password-server.json5")
    monkeypatch.setenv("SIMX_LOGIN", "teacher:correct horse")
    assert hinge(place.come(None, endpoint=""))
    assert hinge(place.come(changed(recipes, "password-client.json5", "correct horse", "wrong horse")))
    v.simxFinish(-1)
    for login, reason in (
        ("teacher:wrong horse", "check user and password in SIMX_LOGIN"),
        ("stranger:correct horse", "check user and password in SIMX_LOGIN"),
        ("teacher", "not USER:PASSWORD"),
        (":correct horse", "not USER:PASSWORD"),
    ):
        caplog.clear()
        monkeypatch.setenv("SIMX_LOGIN", login)
        assert place.come(None, endpoint="") == -1
        assert reason in caplog.text
        assert "horse" not in caplog.text


@needs_openssl
def test_login_that_nobody_wants_is_said(recipes: Path, monkeypatch, caplog) -> None:
    with server(recipes / "pendulum.xml") as process:
        monkeypatch.setenv("SIMX_CONFIG", str(recipes / "password-client.json5"))
        assert v.simxStart("127.0.0.1", process.port, True, True, TIMEOUT, 5) == -1
    assert "wants no login" in caplog.text


@pytest.mark.parametrize(
    ("content", "text"), [(None, "is no existing file"), ("{ mode: ", "is no Zenoh configuration: line 1")]
)
def test_file_of_the_client_that_cannot_be_used_is_said(
    tmp_path, monkeypatch, caplog, content: str | None, text: str
) -> None:
    file = tmp_path / "client.json5"
    if content is not None:
        file.write_text(content)
    monkeypatch.setenv("SIMX_CONFIG", str(file))
    assert v.simxStart("127.0.0.1", free_port(), True, True, TIMEOUT, 5) == -1
    assert text in caplog.text
    assert str(file) in caplog.text


# --- viewers --------------------------------------------------------------------------------------


@needs_openssl
def test_viewer_reads_and_changes_nothing_and_cannot_come_as_another(guard: Guard, caplog) -> None:
    place = guard("roles-server.json5")
    teacher = place.come("password-client.json5")
    student = place.come("viewer-client.json5", role="viewer")
    joint = hinge(student)
    assert v.simxSetJointTargetVelocity(student, joint, 3.0, BLOCKING) == REMOTE_ERROR
    assert v.simxStartSimulation(student, BLOCKING) == REMOTE_ERROR
    assert "is a viewer, who may only read" in "\n".join(v.simxGetLastErrors(student, BLOCKING)[1])
    assert v.simxGetJointPosition(student, joint, v.simx_opmode_streaming)[0] == 1
    assert v.simxSetJointPosition(teacher, joint, 0.5, BLOCKING) == 0
    v.simxGetPingTime(student)
    assert v.simxGetJointPosition(student, joint, BLOCKING) == (0, pytest.approx(0.5))
    # without the role: its calls would have a key that the rules forbid
    assert place.come("viewer-client.json5") == -1
    assert "SIMX_ROLE=viewer" in caplog.text


@needs_openssl
def test_certificate_makes_a_viewer_as_a_user_does(guard: Guard, recipes: Path) -> None:
    name = "roles-server.json5"
    for old, new in (
        ("auth: {", "// auth: {"),
        (
            "listen_private_key",
            f'enable_mtls: true, root_ca_certificate: "{recipes}/ca.pem", listen_private_key',
        ),
        ('usernames: ["student"]', 'cert_common_names: ["alice"]'),
    ):
        name = changed(recipes, name, old, new)
    place = guard(name)
    alice = place.come("mtls-client.json5", role="viewer")
    assert hinge(alice)
    assert v.simxStartSimulation(alice, BLOCKING) == REMOTE_ERROR
    assert place.come("mtls-client.json5") == -1
    assert place.come(None, endpoint="") == -1


def _name_of(client: int) -> str:
    connection: Any = CLIENTS.get(client)
    return connection._transport.zenoh.client


@needs_openssl
def test_nobody_speaks_in_the_name_of_another(guard: Guard, recipes: Path) -> None:
    place = guard("roles-server.json5")
    teacher = place.come("password-client.json5")
    realm = place.process.ready.partition("realm=")[2].split()[0]
    start = encode(Batch(1, 0, [Call(1, 0, 0, "simxStartSimulation", [])]))
    zenoh = link.import_zenoh()
    spoken: dict[str, bool] = {}
    for config in ("viewer-client.json5", "password-client.json5"):
        session_options = {"mode": "client", "connect/endpoints": [place.endpoint]}
        defaults = {"scouting/multicast/enabled": False}
        with zenoh.open(
            link.configure(link.configured_by(zenoh, recipes / config, defaults), session_options)
        ) as session:
            tokens = session.liveliness().get(keys.client(realm), timeout=1.0)
            names = [str(token.ok.key_expr).rpartition("/")[2] for token in tokens if token.ok is not None]
            spoken[config] = bool(names)
            for name in names or [_name_of(teacher), "*"]:
                session.put(keys.call(realm, name), start)
            list(session.get(keys.status(realm), timeout=1.0))  # after what was put before
        v.simxGetPingTime(teacher)
        running = v.simxGetInMessageInfo(teacher, v.simx_headeroffset_server_state)[1] & 1
        assert not running
    assert spoken == {"viewer-client.json5": False, "password-client.json5": False}


@needs_openssl
def test_viewer_may_ask_what_the_server_counts(guard: Guard, recipes: Path, monkeypatch) -> None:
    place = guard("roles-server.json5")
    teacher, student = place.come("password-client.json5"), place.come("viewer-client.json5", role="viewer")
    assert hinge(teacher)
    assert hinge(student)
    monkeypatch.setenv("SIMX_CONFIG", str(recipes / "viewer-client.json5"))
    ((found,), unreachable) = measure_servers([place.endpoint])
    assert unreachable == []
    assert found.metrics is not None
    assert {client["role"] for client in found.metrics["clients"]} == {"driver", "viewer"}


@needs_openssl  # which makes the files
def test_router_with_the_rules_lets_no_client_play_the_server(recipes: Path, monkeypatch) -> None:
    port = free_port()
    flags = (
        "--realm",
        "lab",
        "--connect",
        f"tcp/127.0.0.1:{port}",
        "--config",
        recipes / "router-server.json5",
    )
    zenoh = link.import_zenoh()
    config = recipes / "viewer-client.json5"
    options = {"mode": "client", "connect/endpoints": [f"tcp/127.0.0.1:{port}"]}
    heard: list[str] = []
    with router(port, recipes / "router.json5"), server(recipes / "pendulum.xml", *flags):
        monkeypatch.setenv("SIMX_CONFIG", str(config))
        with zenoh.open(link.configure(zenoh.Config.from_file(str(config)), options)) as outsider:
            outsider.declare_queryable(keys.hello("lab"), lambda query: heard.append("hello"), complete=True)
            outsider.declare_subscriber("simx/*/call/*", lambda sample: heard.append("call"))
            outsider.liveliness().declare_token(keys.alive("fake"))
            client = v.simxStart("lab@127.0.0.1", port, True, False, 20_000, 5)
            assert hinge(client)
            alive = outsider.liveliness().get(keys.ANY_ALIVE, timeout=5.0)
            assert [str(token.ok.key_expr) for token in alive if token.ok is not None] == [keys.alive("lab")]
            v.simxFinish(client)
    assert heard == []


def test_viewer_is_refused_every_command_that_changes_something(tmp_path, monkeypatch) -> None:
    (tmp_path / "pendulum.xml").write_text(PENDULUM)
    refused = {name for name, command in ANSWERED.items() if not command.only_reads}
    assert refused >= CHANGING_READERS
    assert {
        "simxStartSimulation",
        "simxCallScriptFunction",
        "simxSynchronous",
        "storeFile",
        "lendFile",
    } <= refused
    monkeypatch.setenv("SIMX_ROLE", "viewer")
    # The temporary port starts the simulation for others, but not for a viewer.
    with server(tmp_path / "pendulum.xml", "--temporary-port", port := free_port(), ports=(port,)) as process:
        client = v.simxStart("127.0.0.1", process.port, True, True, TIMEOUT, 5)
        assert v.simxSetFloatSignal(client, "a", 1.0, BLOCKING) == REMOTE_ERROR
        assert v.simxGetAndClearStringSignal(client, "a", BLOCKING)[0] == REMOTE_ERROR
        assert v.simxSynchronous(client, True) == REMOTE_ERROR
        assert v.simxGetFloatSignal(client, "a", BLOCKING)[0] == REMOTE_ERROR
        errors = v.simxGetLastErrors(client, BLOCKING)[1]
        assert sum("may only read" in text for text in errors) == 3
        v.simxFinish(client)
        monkeypatch.setenv("SIMX_ROLE", "king")
        assert v.simxStart("127.0.0.1", process.port, True, True, TIMEOUT, 5) == -1
