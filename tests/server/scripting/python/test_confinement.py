"""Every command that takes a path is given paths that lead out of the workspace, in all the ways there are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from real_world import BLOCKING, RealWorld
from scenes_for_tests import ARM

import simx_client as v
from simx_client.calls.marshalling import Marshal
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.commands import ANSWERED
from simx_server.errors import CommandError
from simx_server.files import workspace

pytestmark = pytest.mark.slow

REMOTE_ERROR = v.simx_return_remote_error_flag
CUBE = "<mujoco><worldbody><body name='cube'><geom type='box' size='.1 .1 .1'/></body></worldbody></mujoco>"
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
PANEL = '[[ui]]\nname = "panel"\n[[ui.element]]\nid = 3\nkind = "button"\n'
SECRETS = {"secret.xml": CUBE, "secret.obj": TETRAHEDRON, "secret.toml": PANEL}

ODD_BUT_INSIDE = [
    "~/{name}",
    "~root/{name}",
    "$HOME/{name}",
    "%2e%2e/{name}",
    "..%2f{name}",
    "\uff0e\uff0e/{name}",
    "..\u2215{name}",
    ".../{name}",
    "file://{outside}/{name}",
]
"""Ways out for programs that expand, decode or normalise names; no such files are there."""

WAYS_OUT = [
    *ODD_BUT_INSIDE,
    "../{name}",
    "inside/../../{name}",
    "./inside/.././../{name}",
    "..\\{name}",
    "inside\\..\\..\\{name}",
    "inside/..\\../{name}",
    "{outside}/{name}",
    "/{outside}/{name}",
    "/proc/self/cwd/../{name}",
    "/proc/self/root{outside}/{name}",
    "C:\\{name}",
    "C:{name}",
    "C:..\\{name}",
    "\\\\host\\share\\{name}",
    "//host/share/{name}",
    "\\\\?\\C:\\{name}",
    "\\\\.\\{name}",
    "link/{name}",
    "link-{name}",
    "chain-{name}",
    "dangling/../{name}",
    "loop/{name}",
    "../{name}\0",
    "arm.xml\0/../../{name}",
    "\0../{name}",
    "{name}/" + "../" * 40 + "{outside}/{name}",
    "x/" * 3000 + "{name}",
    "../" * 1300 + "{name}",
]


def lay_out(outside: Path) -> Path:
    """Make a workspace in a folder; beside it forbidden files, and links to that from the inside."""
    folder = outside / "workspace"
    (folder / "inside").mkdir(parents=True)
    (folder / "arm.xml").write_text(ARM)
    (folder / "link").symlink_to(outside)
    (folder / "dangling").symlink_to(outside / "not there")
    (folder / "loop").symlink_to(folder / "loop")
    for name, content in SECRETS.items():
        (outside / name).write_text(content)
        (folder / f"link-{name}").symlink_to(outside / name)
        (folder / f"chain-{name}").symlink_to(folder / f"link-{name}")
    return folder


def stand(monkeypatch: pytest.MonkeyPatch, outside: Path) -> None:
    """Stand where a shell's or a wrong reading of relative names would look."""
    monkeypatch.setenv("HOME", str(outside))
    monkeypatch.chdir(outside)


@pytest.fixture
def there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The workspace."""
    stand(monkeypatch, tmp_path)
    return lay_out(tmp_path)


@pytest.fixture
def world(there: Path) -> Iterator[RealWorld]:
    world = RealWorld(there / "arm.xml", workspace=there)
    yield world
    world.close()


@pytest.fixture
def client(world: RealWorld) -> int:
    return world.client()


@pytest.fixture(scope="module")
def outside(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder around the workspace of `lasting`."""
    return tmp_path_factory.mktemp("outside")


@pytest.fixture(scope="module")
def lasting(outside: Path) -> Iterator[RealWorld]:
    """A world for calls that leave files as they are."""
    folder = lay_out(outside)
    world = RealWorld(folder / "arm.xml", workspace=folder)
    yield world
    world.close()


@pytest.fixture
def visitor(lasting: RealWorld, outside: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A new client of that world."""
    stand(monkeypatch, outside)
    client = lasting.client()
    yield client
    v.simxFinish(client)


def everything(folder: Path) -> dict[str, bytes | None]:
    """The files in a folder and beneath: relative name to content, None for others than files."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() and not path.is_symlink() else None
        for path in folder.rglob("*")
        if not path.is_symlink() or path.parent.name == "workspace"
    }


COMMANDS: dict[str, tuple[str, str, list[Any]]] = {
    "load scene": ("secret.xml", "simxLoadScene", [0]),
    "load model": ("secret.xml", "simxLoadModel", [0]),
    "load mesh": ("secret.obj", "simxLoadModel", [0]),
    "load UI": ("secret.toml", "simxLoadUI", [0]),
    "erase": ("secret.xml", "simxEraseFile", []),
    "store": ("secret.xml", "storeFile", [b"overwritten"]),
}
"""What is wanted, the command, and its arguments behind the path."""


def send(client: int, command: str, arguments: list[Any]) -> tuple[int, str]:
    """The code, and the error's text. The arguments go as they are; the functions end a text at its NUL, as C did."""
    connection: Any = CLIENTS.get(client)
    result = connection.blocking(Marshal(ANSWERED[command]), arguments)
    return result[0] if isinstance(result, tuple) else result, "\n".join(
        v.simxGetLastErrors(client, BLOCKING)[1]
    )


@pytest.mark.parametrize(
    ("command", "way"),
    [
        (command, way)
        for command in COMMANDS
        for way in WAYS_OUT
        if command != "store" or way not in ODD_BUT_INSIDE
    ],
    ids=lambda text: ascii(text[:30]),
)
def test_no_command_finds_the_way_out(
    visitor: int, lasting: RealWorld, outside: Path, command: str, way: str
) -> None:
    name, function, more = COMMANDS[command]
    before, scene = everything(outside), lasting.simulation.scene
    number_of_objects = len(scene.objects)
    code, text = send(visitor, function, [way.format(name=name, outside=outside), *more])
    assert code == REMOTE_ERROR
    assert text
    assert "internal error" not in text
    assert everything(outside) == before
    assert lasting.simulation.scene is scene
    assert len(scene.objects) == number_of_objects
    assert v.simxGetUIHandle(visitor, "panel", BLOCKING)[0] == REMOTE_ERROR


@pytest.mark.parametrize("way", ODD_BUT_INSIDE)
def test_odd_names_of_new_files_mean_files_of_the_workspace(client: int, there: Path, way: str) -> None:
    name = way.format(name="new.bin", outside="")
    assert send(client, "storeFile", [name, b"content"])[0] == 0
    assert (there / name.replace("\\", "/")).read_bytes() == b"content"


@pytest.mark.parametrize("way", WAYS_OUT, ids=lambda way: ascii(way[:30]))
def test_file_that_is_sent_ahead_goes_under_a_name_of_its_own(visitor: int, outside: Path, way: str) -> None:
    before = everything(outside)
    name = way.format(name="secret.xml", outside=outside)
    if send(visitor, "lendFile", ["path", name, CUBE.encode()])[0] == 0:
        send(visitor, "simxLoadModel", ["path", 1])
    assert everything(outside) == before


REFERENCES = {
    "link": "<mujoco><asset><mesh name='m' file='link-secret.obj'/></asset></mujoco>",
    "folder through a link": "<mujoco><compiler meshdir='link'/>"
    "<asset><mesh name='m' file='secret.obj'/></asset></mujoco>",
    "two halves": "<mujoco><compiler assetdir='inside/..'/>"
    "<asset><mesh name='m' file='../secret.obj'/></asset></mujoco>",
    "URDF": "<robot name='r'><link name='l'><visual><geometry><mesh filename='package://../secret.obj'/></geometry>"
    "</visual></link></robot>",
    "sub-model": "<mujoco><asset><model name='m' file='../secret.xml'/></asset></mujoco>",
    "six sides": "<mujoco><asset><texture name='t' type='cube' fileup='../secret.obj'/></asset></mujoco>",
    "entity": "<!DOCTYPE mujoco [<!ENTITY out '../secret.obj'>]>"
    "<mujoco><asset><mesh name='m' file='&out;'/></asset></mujoco>",
    "outer entity": "<!DOCTYPE mujoco [<!ENTITY out SYSTEM 'file:///etc/hostname'>]><mujoco model='m'>&out;</mujoco>",
    "character reference": "<mujoco><asset><mesh name='m' file='&#46;&#46;&#47;secret.obj'/></asset></mujoco>",
    "many laughs": "<!DOCTYPE mujoco [<!ENTITY a0 'ha'>"
    + "".join(f"<!ENTITY a{n} '{f'&a{n - 1};' * 10}'>" for n in range(1, 10))
    + "]><mujoco model='m'>&a9;</mujoco>",
}


@pytest.mark.parametrize("kind", REFERENCES)
def test_file_does_not_name_what_its_sender_may_not(
    client: int, world: RealWorld, there: Path, kind: str
) -> None:
    (there / "spy.xml").write_text(REFERENCES[kind])
    scene = world.simulation.scene
    assert v.simxLoadScene(client, "spy.xml", 0, BLOCKING) == REMOTE_ERROR
    assert v.simxLoadModel(client, "spy.xml", 0, BLOCKING)[0] == REMOTE_ERROR
    assert world.simulation.scene is scene


def test_workspace_that_is_itself_behind_a_link_is_no_way_out(there: Path, tmp_path: Path) -> None:
    other = tmp_path / "other name"
    other.symlink_to(there)
    assert workspace.path_within(other, "new.xml") == there.resolve() / "new.xml"
    with pytest.raises(CommandError, match="link"):
        workspace.path_within(other, "link/secret.xml")


def test_erasing_takes_no_folder_and_no_workspace(client: int, there: Path) -> None:
    for name in (".", "inside", "inside/", "./", "inside/."):
        assert v.simxEraseFile(client, name, BLOCKING) == REMOTE_ERROR
    assert (there / "inside").is_dir()
