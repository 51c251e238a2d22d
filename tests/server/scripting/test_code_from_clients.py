"""No code of a client's runs without --allow-code, however it gets to the server; the operator's own does."""

from __future__ import annotations

import os
import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from real_world import BLOCKING, RealWorld, handle_of

import simx_client as v
from simx_server.errors import CommandError
from simx_server.limits import Limits
from simx_server.scene.finding import client_files

pytestmark = pytest.mark.slow

REMOTE_ERROR = v.simx_return_remote_error_flag
RAN = "function sysCall_init() sim.setInt32Signal('ran', 1) end\nfunction hello() return {}, {}, {}, '' end"
EVIL = "function sysCall_init() sim.setInt32Signal('evil', 1) end"


def scene(script: str = "", body: str = "<body name='base'><geom size='.1'/></body>") -> str:
    """A scene of one object; `script` is an element of its <custom>."""
    return f"<mujoco model='s'><worldbody>{body}</worldbody><custom>{script}</custom></mujoco>"


def text(source: str, name: str = "lua:base") -> str:
    return f'<text name="simx:{name}" data={quoteattr(source, {chr(10): "&#10;"})}/>'


BY_FILE = '<text name="simx:script:base" data="file=arm.lua"/>'


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """The client's folder."""
    (tmp_path / "client").mkdir()
    return tmp_path / "client"


@pytest.fixture
def there(tmp_path: Path) -> Path:
    """The server's workspace, with the operator's files."""
    folder = tmp_path / "server"
    folder.mkdir()
    (folder / "empty.xml").write_text(scene())
    (folder / "own.xml").write_text(scene(BY_FILE))
    (folder / "arm.lua").write_text(RAN)
    return folder


Open = Callable[..., tuple[RealWorld, int]]


@pytest.fixture
def open_world(there: Path) -> Iterator[Open]:
    worlds: list[RealWorld] = []

    def opened(start: str = "empty.xml") -> tuple[RealWorld, int]:
        worlds.append(RealWorld(there / start, workspace=there))
        return worlds[-1], worlds[-1].client()

    yield opened
    for world in worlds:
        world.close()


def errors(client: int) -> str:
    return "\n".join(v.simxGetLastErrors(client, BLOCKING)[1])


def has_run(client: int, signal: str = "ran") -> bool:
    """Whether the scene's scripts run when it is started."""
    v.simxStopSimulation(client, BLOCKING)
    v.simxClearIntegerSignal(client, "", BLOCKING)
    assert v.simxStartSimulation(client, BLOCKING) == 0
    found = v.simxGetIntegerSignal(client, signal, BLOCKING) == (0, 1)
    v.simxStopSimulation(client, BLOCKING)
    return found


def send(client: int, here: Path, name: str, content: str | bytes, as_name: str | None = None) -> None:
    data = content.encode() if isinstance(content, str) else content
    (here / name).write_bytes(data)
    assert v.simxTransferFile(client, str(here / name), as_name or name, 5000, BLOCKING) == 0, errors(client)


def load(client: int, path: Path | str, options: int = 0) -> int:
    return v.simxLoadScene(client, str(path), options, BLOCKING)


# --- what a client sends ----------------------------------------------------------------------------


@pytest.mark.parametrize("way", ["lent", "transferred"])
def test_script_in_a_clients_scene_does_not_run_and_the_client_is_told(open_world, here, caplog, way):
    world, client = open_world()
    (here / "evil.xml").write_text(scene(text(EVIL)))
    if way == "lent":
        assert load(client, here / "evil.xml", 1) == 0
    else:
        send(client, here, "evil.xml", scene(text(EVIL)))
        assert load(client, "evil.xml") == 0
    told = errors(client)
    assert "child script of 'base'" in told
    assert "a client sent the scene" in told
    assert "--allow-code" in told
    assert "will not run" in caplog.text
    handle_of(client, "base")  # all else of it is there
    assert not has_run(client, "evil")
    v.simxStartSimulation(client, BLOCKING)
    call = (client, "base", v.sim_scripttype_childscript, "sysCall_init", [], [], [], b"", BLOCKING)
    assert v.simxCallScriptFunction(*call)[0] == REMOTE_ERROR
    assert "--allow-code" in errors(client)
    v.simxStopSimulation(client, BLOCKING)
    world.parts.scripts.allows_code = True
    assert has_run(client, "evil")


def test_customization_script_of_a_client_does_not_run_when_its_scene_is_loaded(open_world, here):
    _, client = open_world()
    (here / "evil.xml").write_text(scene(text(EVIL, "lua:customization:base")))
    assert load(client, here / "evil.xml", 1) == 0
    assert v.simxGetIntegerSignal(client, "evil", BLOCKING)[0] != 0
    assert "--allow-code" in errors(client)


def test_main_script_of_a_client_does_not_run(open_world, here):
    _, client = open_world()
    (here / "evil.xml").write_text(scene(text(EVIL, "lua:main")))
    assert load(client, here / "evil.xml", 1) == 0
    assert not has_run(client, "evil")


def test_python_script_of_a_client_gets_no_process(open_world, here):
    _, client = open_world()
    source = "def sysCall_init():\n    sim.setInt32Signal('evil', 1)"
    (here / "evil.xml").write_text(scene(text(source, "python:base")))
    assert load(client, here / "evil.xml", 1) == 0
    assert not has_run(client, "evil")


@pytest.mark.parametrize("running", [False, True])
def test_script_of_a_clients_model_does_not_run_nor_do_those_of_its_copies(open_world, here, running):
    _, client = open_world()
    (here / "model.xml").write_text(scene(text(EVIL)))
    if running:
        v.simxStartSimulation(client, BLOCKING)
    code, base = v.simxLoadModel(client, str(here / "model.xml"), 1, BLOCKING)
    assert code == 0
    assert "a client sent the scene or model" in errors(client)
    assert v.simxCopyPasteObjects(client, [base], BLOCKING)[0] == 0
    v.simxSetObjectPosition(client, base, -1, [1, 1, 1], BLOCKING)
    assert v.simxGetIntegerSignal(client, "evil", BLOCKING)[0] != 0
    assert running or not has_run(client, "evil")


def test_zipped_scene_of_a_client_is_a_clients(open_world, here):
    _, client = open_world()
    with zipfile.ZipFile(here / "evil.zip", "w") as archive:
        archive.writestr("evil.xml", scene(text(EVIL)))
    send(client, here, "evil.zip", (here / "evil.zip").read_bytes())
    assert load(client, "evil.zip") == 0
    assert not has_run(client, "evil")


def test_clients_scene_may_name_a_script_that_is_the_operators(open_world, here):
    _, client = open_world()
    (here / "changed.xml").write_text(scene(BY_FILE).replace("'.1'", "'.2'"))
    assert load(client, here / "changed.xml", 1) == 0
    assert has_run(client)


def test_clients_scene_cannot_have_any_file_read_as_a_script(open_world, here, there):
    (there / "notes.txt").write_text(RAN)
    _, client = open_world()
    (here / "odd.xml").write_text(scene('<text name="simx:script:base" data="file=notes.txt"/>'))
    assert load(client, here / "odd.xml", 1) == 0
    assert not has_run(client)


# --- the operator's files, before and after a client has written there --------------------------------


def test_operators_scene_in_the_workspace_keeps_its_scripts(open_world):
    _, client = open_world()
    assert load(client, "own.xml") == 0
    assert errors(client) == ""
    assert has_run(client)


def test_operators_scene_keeps_them_also_as_a_clients_file_that_is_the_same(open_world, here, there):
    """Client and server on one machine share a folder, or the client has a copy."""
    _, client = open_world()
    assert load(client, there / "own.xml", 1) == 0
    assert has_run(client)
    send(client, here, "arm.lua", RAN)  # what is there already
    assert not (there / client_files.LEDGER).exists()
    assert has_run(client)


@pytest.mark.parametrize("name", ["arm.lua", "./arm.lua", "sub/../arm.lua", "alias.lua", "deep/link.lua"])
def test_script_overwritten_by_a_client_does_not_run_whatever_it_was_called(open_world, here, there, name):
    (there / "alias.lua").symlink_to("arm.lua")
    (there / "deep").mkdir()
    (there / "deep" / "link.lua").symlink_to(there / "arm.lua")
    _, client = open_world()
    assert load(client, "own.xml") == 0
    (here / "evil.lua").write_text(EVIL)
    code = v.simxTransferFile(client, str(here / "evil.lua"), name, 5000, BLOCKING)
    assert (code == 0) == (".." not in name)
    assert not has_run(client, "evil")
    if code == 0:
        assert "a client sent arm.lua" in errors(client)
        (there / "arm.lua").write_text(RAN + "\n-- looked at by the operator")
        assert has_run(client)


def test_scene_that_names_a_clients_script_by_a_link_does_not_run_it(open_world, here, there):
    (there / "arm.lua").unlink()
    (there / "arm.lua").symlink_to("later.lua")
    _, client = open_world()
    send(client, here, "later.lua", EVIL)
    assert load(client, "own.xml") == 0
    assert not has_run(client, "evil")
    os.link(there / "later.lua", there / "hard.lua")
    (there / "arm.lua").unlink()
    (there / "arm.lua").symlink_to("hard.lua")
    assert not has_run(client, "evil")


def test_part_that_a_client_has_replaced_makes_the_whole_scene_a_clients(open_world, here, there):
    part = "<mujoco><worldbody><body name='base'><geom size='.1'/></body></worldbody>{}</mujoco>"
    (there / "parts").mkdir()
    (there / "parts" / "part.xml").write_text(part.format(""))
    (there / "whole.xml").write_text("<mujoco><include file='parts/part.xml'/></mujoco>")
    _, client = open_world()
    evil = part.format(f"<custom>{text(EVIL)}</custom>")
    send(client, here, "part.xml", evil, "parts/part.xml")
    assert load(client, "whole.xml") == 0
    assert not has_run(client, "evil")
    (there / "whole.xml").write_text("<mujoco><!-- -- --><include file = 'parts/part.xml'/></mujoco>")
    assert client_files.ClientFiles(there).made(there / "whole.xml")  # no strict XML, but MuJoCo may read it


def test_module_that_a_client_has_sent_is_not_required(open_world, here, there):
    (there / "arm.lua").write_text("local tools = require('tools')\n" + RAN)
    _, client = open_world()
    send(client, here, "tools.lua", "sim.setInt32Signal('evil', 1) return {}")
    assert load(client, "own.xml") == 0
    assert not has_run(client, "evil")
    assert "a client sent tools.lua" in errors(client)
    (there / "tools.lua").write_text("return {}")
    assert has_run(client)


def test_scene_that_is_sent_again_and_loaded_by_a_script_is_a_clients(open_world, here, there):
    (there / "arm.lua").write_text("function sysCall_init() sim.loadModel('evil.xml') end")
    _, client = open_world()
    send(client, here, "evil.xml", scene(text(EVIL)))
    assert load(client, "own.xml") == 0
    assert not has_run(client, "evil")


def test_what_a_client_has_stored_is_still_the_clients_after_a_restart(open_world, here, there):
    _, client = open_world()
    send(client, here, "arm.lua", EVIL)
    send(client, here, "own.xml", scene(text(EVIL)))
    send(client, here, "own.xml", scene(BY_FILE + text(EVIL, "lua:customization:base")))
    v.simxFinish(client)
    _, client = open_world("own.xml")  # the operator starts with a file that is not theirs any more
    assert not has_run(client, "evil")


def test_file_left_by_a_server_that_was_killed_in_the_middle_of_a_loading_is_a_clients(open_world, there):
    (there / "REMOTE_API_TEMPFILE_0001.xml").write_text(scene(text(EVIL)))
    _, client = open_world()
    assert load(client, "REMOTE_API_TEMPFILE_0001.xml") == 0
    assert not has_run(client, "evil")


def test_code_in_a_call_is_none(open_world):
    """A function of a script gets four tables, never a text that it could run."""
    world, client = open_world("own.xml")
    v.simxStartSimulation(client, BLOCKING)
    evil = "sim.setInt32Signal('evil', 1)"
    for function in (
        "load",
        "sim.executeScriptString",
        "loadstring",
        "require",
        "dofile",
        "pcall",
        "sim.loadModel",
    ):
        for name in (function, f"{function}@base"):
            v.simxCallScriptFunction(
                client, "base", 1, name, [1], [1.0], [evil, evil], evil.encode(), BLOCKING
            )
    assert v.simxGetIntegerSignal(client, "evil", BLOCKING)[0] != 0
    assert not world.parts.scripts.allows_code


# --- the list ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    [
        client_files.LEDGER,
        client_files.LEDGER.upper(),
        "link",
        "sub/" + client_files.LEDGER,
        client_files.LEDGER + "/x",
    ],
)
def test_client_can_neither_write_nor_erase_the_list(open_world, here, there, name):
    (there / "link").symlink_to(client_files.LEDGER)
    _, client = open_world()
    send(client, here, "arm.lua", EVIL)
    before = (there / client_files.LEDGER).read_bytes()
    (here / "nothing").write_bytes(b"")
    assert v.simxTransferFile(client, str(here / "nothing"), name, 5000, BLOCKING) == REMOTE_ERROR
    assert "own list" in errors(client)
    assert v.simxEraseFile(client, name, BLOCKING) == REMOTE_ERROR
    assert (there / client_files.LEDGER).read_bytes() == before


def test_list_is_readable_by_sha256sum_and_goes_with_the_last_file(open_world, here, there):
    _, client = open_world()
    send(client, here, "a", "one")
    send(client, here, "b", "two", "sub/with blank\nand ü.lua")
    lines = (there / client_files.LEDGER).read_text().splitlines()
    assert lines[0] == "7692c3ad3540bb803c020b3aee66cd8887123234ea0c6e7143c0add73ff431ed  a"
    assert len(lines) == 2
    assert client_files.ClientFiles(there).holds(there / "sub" / "with blank\nand ü.lua")
    assert v.simxEraseFile(client, "a", BLOCKING) == 0
    assert (there / client_files.LEDGER).read_text().splitlines() == [*lines, f"{'0' * 64}  a"]
    assert client_files.ClientFiles(there).count_with(there / "c", 10) == 2
    assert v.simxEraseFile(client, "sub/with blank\nand ü.lua", BLOCKING) == 0
    assert not (there / client_files.LEDGER).exists()


def test_list_does_not_grow_with_files_that_are_sent_again_and_again(there, monkeypatch):
    monkeypatch.setattr(client_files, "_SLACK", 10)
    files, other = client_files.ClientFiles(there), client_files.ClientFiles(there)
    for number in range(100):
        path = there / f"picture{number % 3}"
        (files if number % 2 else other).note(path, str(number).encode())
        path.write_text(str(number))
    assert len((there / client_files.LEDGER).read_text().splitlines()) < 20
    for each in (files, other):
        assert all(each.holds(there / f"picture{number}") for number in range(3))


def test_servers_own_lines_do_not_make_it_read_the_list_again(there, monkeypatch):
    """A list of thousands of long names made each store and load slow."""
    files, other = client_files.ClientFiles(there), client_files.ClientFiles(there)
    reads: list[Path] = []
    read_text = Path.read_text
    monkeypatch.setattr(
        Path, "read_text", lambda path, **how: (reads.append(path), read_text(path, **how))[1]
    )
    files.note(there / "0", b"")
    reads.clear()
    for number in range(20):
        files.note(there / str(number), b"")
        (there / str(number)).touch()
        assert files.holds(there / str(number))
    for number in range(10):
        files.forget(there / str(number))
    assert not files.holds(there / "3")
    assert reads == []
    assert other.holds(there / "15")  # what another server has written is read
    assert not other.holds(there / "5")
    other.note(there / "new", b"")
    (there / "new").touch()
    assert files.holds(there / "new")
    assert len(reads) == 2


def test_files_that_clients_store_have_limits_of_number_and_length(open_world, here, there):
    world, client = open_world()
    world.parts.simulation.limits = Limits(files=4)
    (here / "a").touch()

    def stored(name: str) -> bool:
        return v.simxTransferFile(client, str(here / "a"), name, 5000, BLOCKING) == 0

    assert [stored(name) for name in ("a", "deep/b", "c", "d", "a")] == [True, True, True, False, True]
    assert "limit 'files'" in errors(client)
    assert not stored("deeper/b")
    assert not (there / "deeper").exists()
    assert v.simxEraseFile(client, "deep/b", BLOCKING) == 0
    assert not (there / "deep").exists()
    assert stored("d")
    (there / "a").unlink()  # the operator removes one too
    assert [stored(name) for name in ("e", "f", "g")] == [True, True, False]
    world.parts.simulation.limits = Limits()
    assert stored("x" * 200 + "/" + "y" * 54)
    errors(client)
    assert not stored("x" * 200 + "/" + "y" * 55)
    assert "at most 255" in errors(client)


def test_nothing_is_stored_when_the_list_cannot_be_written(there):
    (there / client_files.LEDGER).mkdir()
    with pytest.raises(CommandError, match="nothing is stored"):
        client_files.ClientFiles(there).note(there / "new.lua", b"x")


def test_another_server_of_the_same_workspace_knows_at_once(open_world, here, there):
    _, client = open_world()
    _, other = open_world("own.xml")
    assert has_run(other)
    send(client, here, "arm.lua", EVIL)
    assert not has_run(other, "evil")
    shutil.copy(there / "arm.lua", there / "checked.lua")  # what the operator moves is the operator's
    assert not client_files.ClientFiles(there).holds(there / "checked.lua")
