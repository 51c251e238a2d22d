"""Mesh files as parts: COLLADA, PLY, STL as text, OBJ with a library; damaged and hostile ones are refused."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from collada_files import BLUE, PLY, RED, TEXT_STL, collada

from simx_client.protocol.cli.installing import extra_line
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.meshes import parts as parts_module
from simx_server.scene.formats.meshes.naming import files_named
from simx_server.scene.formats.meshes.parts import Part, as_one
from simx_server.scene.formats.meshes.reading import is_mujocos, read_parts
from simx_server.scene.formats.sources import Sources

pytest.importorskip("collada", reason=extra_line("urdf"))
pytest.importorskip("trimesh", reason=extra_line("urdf"))


def read(folder: Path, name: str, text: str | bytes, *, turns: bool = False) -> list[Part]:
    file = folder / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_parts(file, name, Sources.of((), {}), turns=turns)


def corners(parts: list[Part]) -> set[tuple[float, ...]]:
    return {tuple(np.round(point, 6).tolist()) for part in parts for point in part.points}


def test_collada_has_a_part_for_each_material(tmp_path: Path) -> None:
    red, blue = read(tmp_path, "t.dae", collada())
    assert (red.look.color, blue.look.color) == (RED, BLUE)
    assert red.look.highlights == pytest.approx(0.4)
    assert (len(red.faces), len(blue.faces)) == (2, 2)
    assert corners([red, blue]) == {(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)}
    assert len(as_one([red, blue]).points) == 4


def test_unit_and_node_of_collada_apply_and_its_up_axis_only_where_asked(tmp_path: Path) -> None:
    text = collada(unit=0.01, up="Y_UP", matrix="1 0 0 100 0 1 0 0 0 0 2 0 0 0 0 1")
    assert corners(read(tmp_path, "t.dae", text)) == {(1, 0, 0), (1.01, 0, 0), (1, 0.01, 0), (1, 0, 0.02)}
    turned = corners(read(tmp_path, "t.dae", text, turns=True))
    assert turned == {(1, 0, 0), (1.01, 0, 0), (1, 0, 0.01), (1, -0.02, 0)}


def test_mirrored_node_keeps_the_outside_outside(tmp_path: Path) -> None:
    for matrix in ("1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1", "-1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"):
        whole = as_one(read(tmp_path, "t.dae", collada(matrix=matrix)))
        a, b, c = (whole.points[whole.faces[:, corner]] for corner in range(3))
        assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(1 / 6)


def test_geometry_with_an_unknown_material_stays(tmp_path: Path) -> None:
    first, second = read(tmp_path, "t.dae", collada(materials=("red", "lost")))
    assert first.look.color == RED
    assert second.look.color is None


def test_image_and_its_places_are_read(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "a b.png").write_bytes(b"")
    text = collada(image="maps\\a%20b.png")
    pictured, _ = read(tmp_path, "t.dae", text)
    assert pictured.look.image == "maps\\a%20b.png"
    assert pictured.coordinates is not None
    assert pictured.coordinates.shape == (2, 3, 2)
    named = list(files_named(tmp_path / "t.dae", text.encode(), Sources.of((), {})))
    assert named == [(tmp_path / "maps" / "a b.png").resolve()]


def test_ply_has_the_mean_of_its_colours(tmp_path: Path) -> None:
    (part,) = read(tmp_path, "t.ply", PLY)
    assert part.look.color == (1, 0, 0, 1)
    assert corners([part]) == {(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)}


def test_stl_as_text_is_read(tmp_path: Path) -> None:
    (part,) = read(tmp_path, "t.stl", TEXT_STL)
    assert len(part.faces) == 4
    assert not is_mujocos(Path("t.stl"), TEXT_STL.encode())


def test_obj_has_the_colours_of_its_library(tmp_path: Path) -> None:
    (tmp_path / "t.mtl").write_text("newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nd 0.5\n")
    text = "mtllib t.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 3 2\nf 1 2 4\nusemtl b\nf 1 4 3\nf 2 3 4\n"
    first, second = read(tmp_path, "t.obj", text)
    assert (first.look.color, second.look.color) == ((1, 0, 0, 1), (0, 1, 0, 0.5))
    assert not is_mujocos(Path("t.obj"), text.encode())
    assert is_mujocos(Path("t.obj"), text.replace("mtllib t.mtl", "").encode())


BOMB = '<!DOCTYPE c [<!ENTITY a "{}"><!ENTITY b "&a;&a;">]>'.format("x" * 100)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_refused_in_any_encoding(tmp_path: Path, encoding: str) -> None:
    text = collada(head=BOMB).replace('version="1.0"', f'version="1.0" encoding="{encoding}"', 1)
    with pytest.raises(SceneError, match="declares XML entities"):
        read(tmp_path, "t.dae", text.encode(encoding))


@pytest.mark.parametrize("encoding", ["utf-32", "utf-7", "euc-jp"])
def test_collada_in_an_encoding_that_only_the_library_knows_is_refused(tmp_path: Path, encoding: str) -> None:
    """Its entities would not be seen."""
    text = collada(head=BOMB).replace('version="1.0"', f'version="1.0" encoding="{encoding}"', 1)
    with pytest.raises(SceneError, match="no well-formed XML in a usual encoding"):
        read(tmp_path, "t.dae", text.encode(encoding))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "is no valid COLLADA"),
        ("<COLLADA/>", "has no triangles"),
        (collada().replace("0 0 2 1 1 2", "0 0 9 1 1 2"), "t.dae"),
        (collada(points="0 0 0 0 0 0 0 0 0 0 0 0"), "has no triangles"),
        ("PK\x03\x04 and more", "packed COLLADA"),
    ],
)
def test_damaged_collada_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        read(tmp_path, "t.dae", text)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (PLY.replace("element vertex 4", "element vertex 4000000000"), "cannot read 't.ply'"),
        (PLY.replace("\n1 0 0 255", "\nnan 0 0 255"), "a point is not finite"),
        (PLY.replace("3 1 2 3", "3 1 2 9"), "t.ply"),
    ],
)
def test_damaged_ply_is_told(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        read(tmp_path, "t.ply", text)


def test_altered_files_are_read_or_refused(tmp_path: Path) -> None:
    """No alteration of a few bytes raises anything but a SceneError, which the user can read."""
    dice = random.Random(7)
    words = (b"0", b"-1", b"4294967295", b"nan", b"1e308", b"", b"#node", b"\0", b"999999999", b"<a/>")
    outcomes = {True: 0, False: 0}
    for name, text in (("t.dae", collada(image="a.png")), ("t.ply", PLY), ("t.stl", TEXT_STL)) * 60:
        parts = text.encode().split(b" ")
        for _ in range(dice.randint(1, 3)):
            parts[dice.randrange(len(parts))] = dice.choice(words)
        try:
            read(tmp_path, name, b" ".join(parts))
        except SceneError:
            outcomes[False] += 1
        else:
            outcomes[True] += 1
    assert min(outcomes.values()) > 10


def test_nodes_that_contain_themselves_are_refused(tmp_path: Path) -> None:
    text = collada().replace("<instance_geometry", '<instance_node url="#node"/><instance_geometry')
    with pytest.raises(SceneError, match=r"t\.dae"):
        read(tmp_path, "t.dae", text)


def test_too_many_triangles_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts_module, "MOST_TRIANGLES", 3)
    with pytest.raises(SceneError, match="more than 3 triangles"):
        read(tmp_path, "t.dae", collada())
