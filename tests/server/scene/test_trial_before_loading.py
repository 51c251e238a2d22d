"""Files that are tried before they are loaded, files that are not, and that the tried bytes are loaded."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import PENDULUM, server, wait_until
from real_world import BLOCKING, RealWorld, handle_of
from scenes_for_tests import ARM

import simx_client as v
from simx_server.scene.formats.vrep import opening
from simx_server.scene.trial import helper as trial_helper
from simx_server.scene.trial.pool import Pool

pytestmark = pytest.mark.slow

REMOTE_ERROR = v.simx_return_remote_error_flag
TETRAHEDRON = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
LARGE = TETRAHEDRON.replace(b"1 0 0", b"3 0 0")
MESHES = b"""<mujoco><asset><mesh name="small" file="parts/m.obj"/><mesh name="large" file="m.obj"/></asset>
<worldbody><body name="block"><freejoint/><geom type="mesh" mesh="small"/><geom type="mesh" mesh="large"/></body>
</worldbody></mujoco>"""


@pytest.fixture
def there(tmp_path: Path) -> Path:
    """The server's workspace."""
    folder = tmp_path / "server"
    folder.mkdir()
    (folder / "arm.xml").write_text(ARM)
    return folder


@pytest.fixture
def world(there: Path) -> Iterator[RealWorld]:
    world = RealWorld(there / "arm.xml", workspace=there)
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> int:
    return world.client()


@pytest.fixture
def send(tmp_path: Path, client: int):
    def send(name: str, data: bytes) -> None:
        (tmp_path / "sent").write_bytes(data)
        assert v.simxTransferFile(client, str(tmp_path / "sent"), name, 5000, BLOCKING) == 0

    return send


@pytest.fixture
def trials(world: RealWorld, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the files that were tried."""
    tried: list[str] = []
    ask = trial_helper.Helper.ask

    def noted(self, request):
        tried.append(request["name"])
        return ask(self, request)

    monkeypatch.setattr(trial_helper.Helper, "ask", noted)
    return tried


def error_of(client: int) -> str:
    return "\n".join(v.simxGetLastErrors(client, BLOCKING)[1])


def sizes(world: RealWorld) -> list[int]:
    """Extents of all meshes, in tenths."""
    model = world.simulation.model
    ends = [(a, a + n) for a, n in zip(model.mesh_vertadr, model.mesh_vertnum, strict=True)]
    return sorted(round(10 * float(abs(model.mesh_vert[a:b]).max())) for a, b in ends)


# --- which files ----------------------------------------------------------------------------------


def test_a_client_s_file_is_tried_stored_or_lent(world, client, send, there, tmp_path, trials) -> None:
    send("stored.xml", ARM.encode())
    assert v.simxLoadScene(client, "stored.xml", 0, BLOCKING) == 0
    (tmp_path / "lent.xml").write_text(ARM + " ")
    assert v.simxLoadScene(client, str(tmp_path / "lent.xml"), 1, BLOCKING) == 0
    send("panel.toml", b'[[ui]]\nname = "panel"\n')
    assert v.simxLoadUI(client, "panel.toml", 0, BLOCKING)[0] == 0
    assert trials == ["stored.xml", "lent.xml", "panel.toml"]


def test_the_operator_s_files_are_loaded_directly_unless_asked(world, client, send, there, trials) -> None:
    send("something.bin", b"of a client")
    assert v.simxLoadScene(client, "arm.xml", 0, BLOCKING) == 0
    assert v.simxLoadModel(client, "models/youbot.xml", 0, BLOCKING)[0] == 0
    assert trials == []
    world.parts.trials.tries_all = True
    assert v.simxLoadScene(client, "arm.xml", 0, BLOCKING) == 0
    assert trials == ["arm.xml"]


@pytest.mark.parametrize("name", ["parts/m.obj", "m.obj"])
def test_an_operator_s_file_that_names_a_client_s_mesh_is_tried(
    world, client, send, there, trials, name
) -> None:
    (there / "parts").mkdir()
    for mesh in ("parts/m.obj", "m.obj"):
        (there / mesh).write_bytes(TETRAHEDRON)
    (there / "own.xml").write_bytes(MESHES)
    assert v.simxLoadScene(client, "own.xml", 0, BLOCKING) == 0
    assert trials == []
    send(name, LARGE)
    assert v.simxLoadScene(client, "own.xml", 0, BLOCKING) == 0, error_of(client)
    assert trials == ["own.xml"]


# --- what was tried is loaded ---------------------------------------------------------------------


def test_a_file_that_changes_after_its_trial_is_not_loaded(world, client, send, there, monkeypatch) -> None:
    send("s.xml", MESHES)
    send("m.obj", LARGE)
    send("parts/m.obj", TETRAHEDRON)
    ask = trial_helper.Helper.ask

    def ask_and_replace(self, request):
        reply = ask(self, request)
        (there / "m.obj").write_bytes(b"hostile")
        return reply

    monkeypatch.setattr(trial_helper.Helper, "ask", ask_and_replace)
    scene = world.simulation.scene
    assert v.simxLoadScene(client, "s.xml", 0, BLOCKING) == REMOTE_ERROR
    assert "'m.obj' was changed while it was being loaded" in error_of(client)
    assert world.simulation.scene is scene


@pytest.mark.parametrize("kind", ["scene", "model"])
def test_an_edit_compiles_the_bytes_that_were_tried(world, client, send, there, kind) -> None:
    send("s.xml", MESHES)
    send("m.obj", LARGE)
    send("parts/m.obj", TETRAHEDRON)
    if kind == "scene":
        assert v.simxLoadScene(client, "s.xml", 0, BLOCKING) == 0, error_of(client)
    else:
        assert v.simxLoadModel(client, "s.xml", 0, BLOCKING)[0] == 0, error_of(client)
    before = sizes(world)
    send("m.obj", b"hostile")
    (there / "parts" / "m.obj").unlink()
    assert v.simxCopyPasteObjects(client, [handle_of(client, "block")], BLOCKING)[0] == 0, error_of(client)
    assert sizes(world) == before
    (there / "plain.xml").write_text(PENDULUM)
    assert v.simxLoadModel(client, "plain.xml", 0, BLOCKING)[0] == 0, error_of(client)
    assert v.simxCopyPasteObjects(client, [handle_of(client, "block")], BLOCKING)[0] == 0, error_of(client)
    assert sizes(world) == before


def test_a_client_s_scene_may_name_shipped_parts(world, client, send) -> None:
    copies = '<custom><text name="simx:copies:Pioneer_p3dx" data="count=1 y=1"/></custom>'
    send("two.xml", f'<mujoco><include file="models/pioneer_p3dx.xml"/>{copies}</mujoco>'.encode())
    assert v.simxLoadScene(client, "two.xml", 0, BLOCKING) == 0, error_of(client)
    assert handle_of(client, "Pioneer_p3dx#0") >= 0
    send(
        "robot.urdf",
        b"""<robot name="r"><link name="base"><collision><geometry><mesh filename="m.obj"/></geometry>
    </collision></link></robot>""",
    )
    send("m.obj", TETRAHEDRON)
    assert v.simxLoadScene(client, "robot.urdf", 0, BLOCKING) == 0, error_of(client)
    assert handle_of(client, "base") >= 0


# --- the child and its helper ---------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_a_long_trial_gives_way_to_the_server(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_helper, "_GIVES_WAY_AFTER", 0.01)
    own = os.getpriority(os.PRIO_PROCESS, 0)

    def wait_for_another_priority(_request: dict[str, object]) -> dict[str, object]:
        until = time.monotonic() + 20
        while os.getpriority(os.PRIO_PROCESS, 0) == own and time.monotonic() < until:
            os.sched_yield()
        return {"priority": os.getpriority(os.PRIO_PROCESS, 0)}

    requests, server = os.pipe()
    made = trial_helper._make_trial({}, requests, wait_for_another_priority)
    os.close(requests)
    os.close(server)
    assert made is not None
    assert made["result"] == {"priority": min(19, own + 10)}


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_from_its_second_file_of_vrep_on_a_helper_has_their_reader(monkeypatch: pytest.MonkeyPatch) -> None:
    imported: list[str] = []
    monkeypatch.setattr(trial_helper.importlib, "import_module", imported.append)
    monkeypatch.setattr(trial_helper, "_make_trial", lambda *_: {"exit": 0, "readers": len(imported)})
    requests, writer = os.pipe()
    reader, replies = os.pipe()
    for name in ("a.ttt", "b.xml", "c.TTM", "d.ttt"):
        trial_helper._send(writer, json.dumps({"path": f"/somewhere/{name}"}).encode())
    os.close(writer)
    trial_helper.serve(requests, replies)
    assert [json.loads(trial_helper._receive(reader))["readers"] for _ in range(4)] == [0, 0, 1, 1]
    assert imported == [opening.__name__]
    for end in (requests, reader, replies):
        os.close(end)


def test_the_next_file_is_tried_after_the_helper_has_died(world, client, send) -> None:
    send("s.xml", ARM.encode())
    assert v.simxLoadScene(client, "s.xml", 0, BLOCKING) == 0
    (used,) = world.parts.trials._pool._idle
    used.kill()
    used._child.wait(10)
    used.is_usable = True
    assert v.simxLoadScene(client, "s.xml", 0, BLOCKING) == REMOTE_ERROR
    assert "load it again" in error_of(client)
    assert v.simxLoadScene(client, "s.xml", 0, BLOCKING) == 0, error_of(client)


def test_a_trial_that_is_given_up_too_late_ends_no_other_trial() -> None:
    pool = Pool()
    pool.add(trial_helper.start())
    try:
        over = pool.take(1.0)
        pool.give_back(over)
        running = pool.take(1.0)
        assert running.helper is over.helper
        over.kill()
        assert running.helper.is_usable
        running.kill()
        assert not running.helper.is_usable
    finally:
        pool.close()


def test_a_trial_that_the_system_kills_is_not_taken_for_one_that_takes_too_long(
    client, send, monkeypatch: pytest.MonkeyPatch
) -> None:
    send("s.xml", ARM.encode())
    monkeypatch.setattr(trial_helper.Helper, "ask", lambda *_: {"exit": -signal.SIGKILL, "seconds": 0.2})
    assert v.simxLoadScene(client, "s.xml", 0, BLOCKING) == REMOTE_ERROR
    assert "the system killed" in error_of(client)


def children_of(process_id: int) -> list[int]:
    found: list[int] = []
    for task in Path(f"/proc/{process_id}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # a thread that has just ended
            found += map(int, (task / "children").read_text().split())
    return found


def is_there(process_id: int) -> bool:
    try:
        state = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def test_others_are_served_during_a_trial_which_ends_with_the_server(there: Path, tmp_path: Path) -> None:
    (tmp_path / "bomb.xml").write_text('<mujoco><size nkey="100000000"/></mujoco>')
    (there / "plain.xml").write_text(PENDULUM)
    with server(
        there / "plain.xml",
        "--workspace",
        there,
        "--limit",
        "load_seconds=60",
        "--limit",
        "load_wait=60",
        ports=(0, 0),
    ) as running:
        children = children_of(running.process.pid)
        assert len(children) == 2, "the watchdog, and the helper"
        for child in children:
            assert not [fd for fd in Path(f"/proc/{child}/fd").iterdir() if "socket" in os.readlink(fd)]
        hostile = v.simxStart("127.0.0.1", running.port, True, True, 5000, 5)
        other = v.simxStart("127.0.0.1", running.ports[1], True, True, 5000, 5)
        assert v.simxLoadScene(hostile, str(tmp_path / "bomb.xml"), 1, v.simx_opmode_oneshot) in (0, 1)
        assert wait_until(lambda: any(map(children_of, children)), 20)
        (trial,) = [each for child in children for each in children_of(child)]
        slowest = 0.0
        for _ in range(20):
            began = time.monotonic()
            assert v.simxGetObjectHandle(other, "arm", BLOCKING)[0] == 0
            slowest = max(slowest, time.monotonic() - began)
        assert is_there(trial), "else nothing was shown"
        assert slowest < 4.0
        os.kill(running.process.pid, signal.SIGKILL)
        running.process.wait(10)
        assert wait_until(lambda: not any(map(is_there, [trial, *children])), 10)
    v.simxFinish(-1)


def test_the_server_decodes_nothing_with_opencv() -> None:
    """Its decoders are large, and what they get must not come from a client: the server only computes and encodes."""
    package = Path(trial_helper.__file__).parents[2]
    decoders = (
        "imread",
        "imdecode",
        "VideoCapture",
        "imreadmulti",
        "imdecodemulti",
        "FileStorage",
        "readNet",
    )
    apart = package / "files" / "image_decoding.py"  # runs in a separate process
    texts = {path: path.read_text() for path in package.rglob("*.py") if path != apart}
    assert [str(path) for path, text in texts.items() for name in decoders if f"cv2.{name}" in text] == []
    assert [str(path) for path, text in texts.items() if "from cv2" in text] == []


_FAULTY = """
import dataclasses, json, sys
from pathlib import Path
from simx_server.limits import Limits
from simx_server.scene.formats.sources import Sources
from simx_server.scene.trial import child

def fails(*_):
    raise KeyError("a fault of the decoder")

child._WORK = {"scene": fails}
described = Sources.of().described()
request = {"kind": "scene", "path": sys.argv[1], "name": "mine.xml", "sources": described, "within": None,
    "limits": dataclasses.asdict(Limits()), "held": 0}
print(json.dumps(child.try_file(request)))
"""


def test_a_fault_of_the_program_is_told_as_one(tmp_path: Path) -> None:
    """It is not a crash of MuJoCo, which the server would take it for without a result."""
    (tmp_path / "mine.xml").write_text(ARM)
    done = subprocess.run(
        [sys.executable, "-c", _FAULTY, str(tmp_path / "mine.xml")],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    result = json.loads(done.stdout)
    assert result["error"] == "SceneError"
    assert "'mine.xml' cannot be loaded: internal error, KeyError: 'a fault of the decoder'" in result["text"]
