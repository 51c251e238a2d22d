"""Files that a spec is written as: MuJoCo reads from them the numbers that the spec has."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from simx_server.scene.formats.exporting.assets import take_out
from simx_server.scene.formats.exporting.check import differing_arrays
from simx_server.scene.formats.exporting.file_names import file_stems
from simx_server.scene.formats.exporting.folder import text_of

SHELL = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
_RANDOM = np.random.default_rng(7)


def any_numbers(*shape: int) -> np.ndarray:
    return _RANDOM.uniform(-1, 1, shape)


def any_turn() -> np.ndarray:
    quaternion = any_numbers(4)
    return quaternion / np.linalg.norm(quaternion)


def add_mesh(spec: mujoco.MjSpec, name: str, *, normals: bool = False, coordinates: bool = False) -> None:
    """Twenty triangles of thirty points; coordinates of textures for each corner."""
    triangles = np.array([_RANDOM.choice(30, 3, replace=False) for _ in range(20)])
    mesh = spec.add_mesh(
        name=name, uservert=any_numbers(90).astype(np.float32), userface=triangles.ravel(), inertia=SHELL
    )
    if normals:
        mesh.usernormal = any_numbers(90).astype(np.float32)
    if coordinates:
        mesh.usertexcoord = any_numbers(120).astype(np.float32)
        mesh.userfacetexcoord = np.arange(60)


def written(spec: mujoco.MjSpec, folder: Path) -> mujoco.MjModel:
    """The model of the files that a spec becomes in a folder."""
    for name, data in take_out(spec).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(data)
    (folder / "scene.xml").write_bytes(text_of(spec, folder))
    return mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


@pytest.mark.parametrize("normals", [False, True])
@pytest.mark.parametrize("coordinates", [False, True])
def test_mesh_has_the_same_points_triangles_normals_and_coordinates(
    tmp_path: Path, normals: bool, coordinates: bool
) -> None:
    spec = mujoco.MjSpec()
    add_mesh(spec, "My mesh/1", normals=normals, coordinates=coordinates)
    body = spec.worldbody.add_body(name="b", pos=any_numbers(3), quat=any_turn())
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_MESH, meshname="My mesh/1", pos=any_numbers(3), quat=any_turn(), mass=1 / 3
    )
    before = spec.copy().compile()
    after = written(spec, tmp_path)
    assert differing_arrays(before, after) == []
    assert len(after.mesh_texcoord) == (60 if coordinates else 0)
    assert (tmp_path / "meshes" / "My_mesh_1.obj").is_file()


@pytest.mark.parametrize("channels", [1, 3, 4])
def test_texture_has_the_same_pixels(tmp_path: Path, channels: int) -> None:
    pixels = _RANDOM.integers(0, 256, (5, 7, channels), np.uint8)
    spec = mujoco.MjSpec()
    texture = spec.add_texture(
        name="t", type=mujoco.mjtTexture.mjTEXTURE_2D, width=7, height=5, nchannel=channels
    )
    texture.data = pixels.tobytes()
    after = written(spec, tmp_path)
    assert after.tex_data.tobytes() == pixels.tobytes()
    assert (after.tex_width[0], after.tex_height[0], after.tex_nchannel[0]) == (7, 5, channels)


def test_height_field_has_the_same_heights(tmp_path: Path) -> None:
    spec = mujoco.MjSpec()
    heights = _RANDOM.uniform(0, 1, 12)
    spec.add_hfield(name="h", nrow=3, ncol=4, size=(1.1, 0.7, 0.3, 0.1), userdata=heights)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname="h")
    before = spec.copy().compile()
    after = written(spec, tmp_path)
    assert differing_arrays(before, after) == []


def test_all_numbers_of_bodies_joints_and_constraints_are_the_same(tmp_path: Path) -> None:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.timestep = 1 / 300
    spec.option.gravity = any_numbers(3)
    parent = spec.worldbody
    for number in range(6):
        parent = parent.add_body(name=f"b{number}", pos=any_numbers(3), quat=any_turn())
        parent.explicitinertial = True
        parent.mass, parent.inertia = 1 / (3 + number), np.array([1.1, 1.2, 1.3]) / 7
        parent.ipos, parent.iquat = any_numbers(3), any_turn()
        joint = parent.add_joint(name=f"j{number}", axis=any_numbers(3), pos=any_numbers(3))
        joint.range, joint.ref, joint.damping[0] = (-1 / 3, 2 / 3), 1 / 7, 1 / 9
        joint.solref_limit = (0.005123456789, 1.00000001)
        parent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=any_numbers(3) ** 2 + 0.1,
            friction=(1 / 3, 1 / 700, 1e-5 / 3),
        )
        parent.add_site(name=f"s{number}", pos=any_numbers(3), quat=any_turn(), size=(1 / 30, 1 / 70, 1 / 90))
        parent.add_camera(name=f"c{number}", pos=any_numbers(3), quat=any_turn(), fovy=100 / 3)
        actuator = spec.add_actuator(name=f"a{number}", target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.gainprm[0], actuator.forcerange = 10 / 3, (-20 / 3, 20 / 3)
    weld = spec.add_equality(
        type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_SITE, name1="s0", name2="s5"
    )
    weld.solref, weld.solimp[:3], weld.data[10] = (1 / 300, 1), (0.9 + 1 / 30, 0.99, 1 / 3000), 1 / 3
    coupled = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1="j1", name2="j2")
    coupled.data[:2] = 1 / 3, 2 / 7
    spec.worldbody.add_body(name="almost", pos=(1e-21, 0, 0), quat=(1, 5e-23, 0, 0)).add_geom(
        size=(0.1, 0, 0)
    )
    heavy = spec.worldbody.add_body(name="almost turned", mass=1, inertia=(1, 1, 1), explicitinertial=True)
    heavy.ipos, heavy.iquat = (0, 0, 0), (1, 5e-19, -2e-28, 0)
    before = spec.copy().compile()
    after = written(spec, tmp_path)
    assert differing_arrays(before, after) == []


def test_models_with_another_number_are_told_apart() -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_body(name="b", pos=(1, 0, 0)).add_geom(size=(0.1, 0, 0))
    before = spec.compile()
    spec.body("b").pos[0] = np.nextafter(1, 2)
    assert differing_arrays(before, spec.compile()) == ["body_pos"]


def test_names_of_files_are_plain_and_differ_also_without_capitals() -> None:
    stems = file_stems(["My shape/1", "My_shape_1", "MY_SHAPE_1", "Größe", "con", "..", "", "a" * 300, "x#0"])
    assert stems["My shape/1"] == "My_shape_1"
    assert stems["con"] == "_con"
    assert stems["x#0"] == "x#0"
    assert len({stem.lower() for stem in stems.values()}) == len(stems)
    assert all(0 < len(stem) < 100 and stem.strip(".") for stem in stems.values())
    assert all(stem.isascii() and "/" not in stem and " " not in stem for stem in stems.values())
