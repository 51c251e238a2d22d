"""``simx_client.Client``: connecting, what goes wrong, its page, its example; in one process and over Zenoh."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from modern_world import SCENE
from processes import ROOT, ServerProcess, server
from real_world import RealWorld

import simx_client as v
from simx_client import Client, errors
from simx_client.connection.clients import CLIENTS
from simx_client.transport.redirect import VARIABLE, format_redirects

pytestmark = pytest.mark.slow

# --- what goes wrong -----------------------------------------------------------------------------


def test_a_wrong_name_suggests_the_nearest(client: Client) -> None:
    with pytest.raises(errors.NoSuchObject, match=r"^no object named 'sholder'; did you mean 'shoulder'"):
        client.joint("sholder")
    with pytest.raises(LookupError):
        client.object("sholder")


def test_an_object_of_another_kind_is_said_with_both_kinds(client: Client) -> None:
    with pytest.raises(errors.WrongKind, match=r"^'red' is a shape, not a joint; client.object"):
        client.joint("red")
    with pytest.raises(TypeError, match="'shoulder' is a joint, not a camera"):
        client.camera("shoulder")


def test_a_removed_object_is_gone_and_its_name_is_looked_up_anew(client: Client) -> None:
    red, again = client.object("red"), client.object("red")
    v.simxRemoveObject(client.id, red.handle, v.simx_opmode_blocking)
    with pytest.raises(errors.ObjectGone, match=r"^shape 'red' was removed from the scene; look it up again"):
        _ = again.position
    with pytest.raises(errors.ObjectGone, match=r"^shape 'red' was removed"):
        _ = red.parent
    with pytest.raises(errors.NoSuchObject):
        client.object("red")
    client.object("blue").remove()
    with pytest.raises(errors.NoSuchObject):
        client.object("blue")


def test_objects_of_a_scene_that_another_client_replaced_are_gone(
    world: RealWorld, client: Client, tmp_path: Path
) -> None:
    shoulder = client.joint("shoulder")
    (tmp_path / "other.xml").write_text(SCENE)
    world.simulation.load(tmp_path / "other.xml")
    for _ in range(2):
        with pytest.raises(
            errors.ObjectGone, match=r"^joint 'shoulder' belongs to a scene that was replaced"
        ):
            _ = shoulder.position
    assert client.joint("shoulder").position == 0.0


def test_a_refusal_has_the_servers_reason_and_the_call(client: Client) -> None:
    with pytest.raises(
        errors.RemoteError,
        match=r"^there is no child script of 'red'.*\(simxCallScriptFunction\('red', 1, 'go'",
    ):
        client.call("go", client.object("red"))


def test_what_waits_for_a_step_is_refused_by_the_step(client: Client) -> None:
    with client.stepping() as step:
        client.object("red").parent = client.object("blue")
        with pytest.raises(errors.RemoteError, match=r"mocap .*\(simxSetObjectParent"):
            step()
        step()
    assert client.simulation.state == "stopped"


def test_no_answer_in_time_and_no_server_have_exceptions_of_their_own(
    world: RealWorld, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    shoulder = client.joint("shoulder")
    client.timeout = 0.02
    with monkeypatch.context() as patch:
        patch.setattr(world.loop, "turn", lambda max_wait=0.0: None)
        with pytest.raises(TimeoutError, match=r"^no answer within 0\.02 s \(simxGetJointPosition"):
            _ = shoulder.position
    client.timeout = 2.0
    assert shoulder.position == 0.0
    CLIENTS.by_id[client.id]._transport.lose()  # type: ignore[union-attr]
    with pytest.raises(ConnectionError, match=r"^the server went away at"):
        _ = shoulder.position


def test_a_closed_client_says_so(client: Client) -> None:
    shoulder = client.joint("shoulder")
    client.close()
    with pytest.raises(errors.NotConnected, match="this client was closed"):
        _ = shoulder.position


@pytest.mark.parametrize(
    ("address", "port", "where"),
    [
        ("here", None, ("here", 19997)),
        ("here:7", None, ("here", 7)),
        ("lab-3@router:7447", None, ("lab-3@router", 7447)),
        ("::1", None, ("::1", 19997)),
        ("[::1]:7", None, ("[::1]", 7)),
        ("here", 8, ("here", 8)),
    ],
)
def test_the_port_may_stand_in_the_address(address: str, port: int | None, where: tuple[str, int]) -> None:
    from simx_client.client.opening import split_port

    assert split_port(address, port) == where


def test_a_port_in_two_places_and_an_impossible_one_are_refused() -> None:
    with pytest.raises(ValueError, match="leave one out"):
        Client("here:7", 8)
    with pytest.raises(ValueError, match=r"must be 1\.\.65535"):
        Client("here", 70000)


# --- the surface stays what it is ------------------------------------------------------------------


def test_the_client_is_no_part_of_the_drop_in_surface_and_loaded_only_when_asked_for() -> None:
    assert "Client" not in v.__all__
    program = """
        import sys, simx_client
        assert "Client" not in dir(simx_client)
        print([m for m in sys.modules if m.startswith(("simx_client.client", "numpy"))])
        from simx_client import Client
        print([m for m in sys.modules if m in ("simx_client.client.client", "numpy", "zenoh")])
    """
    program = "\n".join(line.strip() for line in program.splitlines())
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert done.stdout.splitlines() == ["[]", "['simx_client.client.client']"]
    with pytest.raises(AttributeError, match="no attribute 'Clint'"):
        v.Clint  # type: ignore[attr-defined]  # noqa: B018


# --- over Zenoh ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def tutorial() -> Iterator[ServerProcess]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MUJOCO_GL", "disable")
        with server("ur5_rg2_kinect", "--speed", "max", "--realm", "lab-3", "-q") as process:
            yield process


@pytest.fixture
def redirect(tutorial: ServerProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    """Connections to port 19997 reach this server."""
    monkeypatch.setenv(VARIABLE, format_redirects({19997: ("127.0.0.1", tutorial.port)}))


def test_clients_come_by_port_and_by_name_several_at_a_time_and_beside_legacy_ones(
    tutorial: ServerProcess,
) -> None:
    legacy = v.simxStart("127.0.0.1", tutorial.port, True, True, 5000, 5)
    with (
        Client("127.0.0.1", tutorial.port) as first,
        Client(f"lab-3@127.0.0.1:{tutorial.port}") as second,
    ):
        assert sorted([legacy, first.id, second.id]) == [0, 1, 2]
        first.signals["from"] = "first"
        assert second.signals["from"] == "first"
        code, value = v.simxGetStringSignal(legacy, "from", v.simx_opmode_blocking)
        assert (code, value) == (0, bytearray(b"first"))
    assert (first.id, second.id) == (-1, -1)
    v.simxFinish(legacy)


def test_a_client_that_nobody_holds_any_more_is_closed(tutorial: ServerProcess) -> None:
    client = Client("127.0.0.1", tutorial.port)
    number = client.id
    client.joint("UR5_joint1").position = 0
    del client
    assert CLIENTS.get(number) is None


def test_the_tutorials_ball_is_seen_where_and_as_far_away_as_it_is(tutorial: ServerProcess) -> None:
    with Client("127.0.0.1", tutorial.port) as client:
        arm = client.joints(*[f"UR5_joint{number}" for number in range(1, 7)])
        camera, ball = client.camera("kinect_rgb"), client.object("Target")
        with client.stepping() as step:
            arm.positions = targets = np.radians([90, -45, 90, 0, -100, 0])
            arm.target_positions = targets
            step()
            picture, depth = camera.rgb().astype(int), client.camera("kinect_depth").depth()
            (left, up, ahead), f = (
                ball.relative_to(camera).position,
                320 / np.tan(camera.perspective_angle / 2),
            )
        red, green, blue = picture[:, :, 0], picture[:, :, 1], picture[:, :, 2]
        rows, columns = np.nonzero((blue > 120) & (blue > red + 60) & (green > red + 40))
        column, row = 320 - f * left / ahead, 240 - f * up / ahead
        assert (columns.min() + columns.max()) / 2 == pytest.approx(column, abs=2)
        assert (rows.min() + rows.max()) / 2 == pytest.approx(row, abs=2)
        # Of a sphere of 0.05 m, the ray through the middle of its outline meets the nearest point.
        ray = np.array([left, up, ahead])
        nearest = ahead * (1 - 0.05 / np.linalg.norm(ray))
        assert depth[round(row), round(column)] == pytest.approx(nearest, abs=0.002)


def test_no_server_is_an_exception_with_the_reason(tutorial: ServerProcess) -> None:
    with pytest.raises(errors.ConnectionFailed, match=r"tried .*nobody.*lab-3"):
        Client(f"nobody@127.0.0.1:{tutorial.port}", timeout=2.0)


def test_the_example_turns_the_camera_to_the_ball(
    tutorial: ServerProcess, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(ROOT / "examples")
    import modern_loop  # type: ignore[import-not-found]

    with Client("127.0.0.1", tutorial.port) as client:
        assert modern_loop.follow(client, passes=100) < 0.02


@pytest.mark.usefixtures("redirect")
def test_the_page_about_it_runs_as_it_stands() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len(blocks) > 6
    program = ModuleType("page")
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), vars(program))


def test_the_page_names_only_what_there_is() -> None:
    page = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    for name in re.findall(r"\bsimx[A-Z]\w+", page):
        assert hasattr(v, name), name
    for name in re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE):
        assert issubclass(getattr(errors, name), errors.SimxError), name
