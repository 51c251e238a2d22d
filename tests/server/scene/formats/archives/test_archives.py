"""Files of saved scenes: what is in them, and damaged and hostile ones."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import mujoco
import pytest

from simx_server.scene.formats.annotations import SceneError, read_annotations
from simx_server.scene.formats.archives.archive import NOTE, XML, is_archive, is_archive_file, pack, unpack
from simx_server.scene.formats.archives.packing import files_of
from simx_server.scene.formats.exporting.folder import write_folder
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.formats.saving import save_mjcf
from simx_server.scene.formats.sources import Sources

_TEXT = """<mujoco model="two"><option timestep="0.00123456789"/>
  <asset><mesh name="wedge" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/>
    <texture name="dots" type="2d" builtin="checker" width="8" height="8"/></asset>
  <worldbody>
  <body name="box" pos="0.3333333333333333 0 0"><geom type="mesh" mesh="wedge"/><freejoint name="free"/></body>
  <body name="arm" pos="0 0 2"><joint name="hinge" axis="0 1 0"/><geom size="0.1"/></body></worldbody>
  <custom><text name="simx:lua:box" data="-- a &lt;script&gt; with &quot;quotes&quot;"/></custom>
  <keyframe><key name="simx:start" qpos="1 2 3 1 0 0 0 0.5"/></keyframe></mujoco>"""


def saved(*, is_model: bool = False) -> bytes:
    spec = mujoco.MjSpec.from_string(_TEXT)
    return pack(files_of(spec, read_annotations(spec)), is_model=is_model)


def stored(folder: Path, data: bytes) -> Path:
    file = folder / "saved.ttt"
    file.write_bytes(data)
    return file


def changed(name: str, data: bytes | None) -> bytes:
    """A saved scene with one file that has other content, or is missing."""
    files, _ = unpack(saved())
    files[name] = data or b""
    if data is None:
        del files[name]
    return pack(files, is_model=False)


def text_with(old: str, new: str) -> bytes:
    files, _ = unpack(saved())
    text = files[XML].decode()
    assert old in text
    return changed(XML, text.replace(old, new).encode())


def test_an_archive_has_a_note_the_mjcf_text_and_the_files_that_it_names(tmp_path: Path) -> None:
    data = saved()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert archive.namelist()[:2] == [NOTE, XML]
        assert set(archive.namelist()[2:]) == {"meshes/wedge.obj", "scripts/box.child.lua"}
        assert archive.testzip() is None
    assert is_archive(data)
    assert is_archive_file(stored(tmp_path, data))
    assert not is_archive_file(tmp_path / "missing")
    assert not is_archive(b"PK\x03\x04" + data[60:])
    assert data == saved()


def test_a_scene_starts_at_the_positions_of_its_keyframe(tmp_path: Path) -> None:
    scene, model = load_scene(stored(tmp_path, saved()))
    data = mujoco.MjData(model)
    scene.start.put_into(model, data)
    assert data.qpos.tolist() == [1, 2, 3, 1, 0, 0, 0, 0.5]
    assert model.qpos0.tolist() == [1 / 3, 0, 0, 1, 0, 0, 0, 0]
    assert model.opt.timestep == 0.00123456789
    assert model.nkey == 0


@pytest.mark.parametrize("numbers", ["1 2", "1 2 3 1 0 0 0 0.5 7"])
def test_a_keyframe_that_does_not_fit_is_refused(tmp_path: Path, numbers: str) -> None:
    file = stored(tmp_path, text_with('qpos="1 2 3 1 0 0 0 0.5"', f'qpos="{numbers}"'))
    with pytest.raises(SceneError, match=r"qpos|simx:start"):
        load_scene(file)


def test_an_unpacked_archive_is_the_same_scene(tmp_path: Path) -> None:
    with zipfile.ZipFile(io.BytesIO(saved())) as archive:
        archive.extractall(tmp_path)
    scene, model = load_scene(tmp_path / XML)
    again, other = load_scene(stored(tmp_path, saved()))
    assert model.mesh_vert.tobytes() == other.mesh_vert.tobytes()
    assert scene.start.joints.keys() == again.start.joints.keys()
    assert [item.name for item in scene.objects.values()] == [item.name for item in again.objects.values()]


def test_convert_writes_a_saved_scene_as_a_folder(tmp_path: Path) -> None:
    written = write_folder(stored(tmp_path, saved()), tmp_path / "out", Sources.of())
    scene, model = load_scene(written)
    assert scene.start.joints["hinge"].tolist() == [0.5]
    assert model.nmeshvert == 4
    assert (tmp_path / "out" / "scripts" / "box.child.lua").read_text() == '-- a <script> with "quotes"'
    with pytest.raises(SceneError, match="--convert FOLDER"):
        save_mjcf(tmp_path / "saved.ttt", tmp_path / "x.xml", Sources.of())


def test_a_cut_off_file_says_that_it_is_damaged(tmp_path: Path) -> None:
    data = saved()
    for length in range(len(data) // 8, len(data), len(data) // 8):
        with pytest.raises(SceneError, match=r"saved\.ttt.*damaged or cut off|saved by simx-server"):
            load_scene(stored(tmp_path, data[:length]))


def test_a_changed_byte_never_gives_another_error_than_that_of_a_scene(tmp_path: Path) -> None:
    data = saved()
    errors = 0
    for place in range(0, len(data), 17):
        damaged = bytearray(data)
        damaged[place] ^= 0x55
        try:
            load_scene(stored(tmp_path, bytes(damaged)))
        except SceneError:
            errors += 1
    assert errors > len(data) // 17 // 2


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('file="meshes/wedge.obj"', 'file="/etc/passwd"', "names the file '/etc/passwd', which is not in it"),
        ("<worldbody>", '<include file="model.xml"/><worldbody>', "has <include>"),
        ("<worldbody>", '<asset><model name="m" file="model.xml"/></asset><worldbody>', "has <model>"),
        ('<compiler angle="radian"', '<compiler meshdir="/etc" angle="radian"', "has meshdir"),
        ("<worldbody>", "<worldbody", "no well-formed XML"),
        ('body name="box"', 'body name="arm"', "repeated name 'arm'"),
    ],
)
def test_a_text_that_names_what_is_not_in_the_file_is_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        load_scene(stored(tmp_path, text_with(old, new)))


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        (XML, None, f"has no {XML}"),
        ("meshes/wedge.obj", None, "names the file 'meshes/wedge.obj'"),
        ("meshes/wedge.obj", b"not a mesh", "wedge"),
    ],
)
def test_a_missing_or_wrong_part_is_named(
    tmp_path: Path, name: str, data: bytes | None, message: str
) -> None:
    with pytest.raises(SceneError, match=message):
        load_scene(stored(tmp_path, changed(name, data)))


def test_an_archive_of_a_later_form_is_refused(tmp_path: Path) -> None:
    data = saved().replace(b"form: 1\n", b"form: 7\n")
    with pytest.raises(SceneError, match=r"damaged|another version"):
        load_scene(stored(tmp_path, data))
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr(NOTE, "form: 2\nkind: scene\n")
    with pytest.raises(SceneError, match=r"another version of simx-server.*form: 2"):
        load_scene(stored(tmp_path, target.getvalue()))


def test_an_archive_that_grows_beyond_all_bounds_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("simx_server.scene.formats.archives.archive.MOST_UNPACKED", 100_000)
    with pytest.raises(SceneError, match=r"at most .* of 100000 bytes"):
        load_scene(stored(tmp_path, changed("meshes/wedge.obj", b" " * 100_000)))
