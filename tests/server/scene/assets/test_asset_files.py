"""Meshes and images of a scene become files in memory, which MuJoCo processes once; nothing else changes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import mujoco
import numpy as np
import pytest
from handler_calls import World

from simx_server.editing import creating, models
from simx_server.history.models import pack_model, unpack_model
from simx_server.scene.assets.filing import file_assets, points_and_faces
from simx_server.scene.assets.naming import is_name
from simx_server.scene.editing import editing
from simx_server.scene.formats.exporting.check import differing_arrays
from simx_server.scene.formats.loader import load_text

POINTS = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 2]
FACES = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
NORMALS = [0, 0, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1]
COORDINATES = [0, 0, 1, 0, 0, 1, 0.25, 0.75]

FORMS: dict[str, dict[str, Any]] = {
    "points alone": {},
    "triangles": {"userface": FACES},
    "normals": {"userface": FACES, "usernormal": NORMALS},
    "all": {"userface": FACES, "usernormal": NORMALS, "usertexcoord": COORDINATES},
}

WEDGE = """
<mujoco>
  <asset><mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 2.{}"/></asset>
  <worldbody><body name="wedge" pos="0 0 {}"><geom name="wedge" type="mesh" mesh="wedge"/></body></worldbody>
</mujoco>
"""


def spec_of(form: dict[str, Any], kind: Any = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL) -> Any:
    spec: Any = mujoco.MjSpec()
    mesh = spec.add_mesh(name="wedge", inertia=kind, uservert=POINTS)
    for name, values in form.items():
        setattr(mesh, name, values)
    spec.worldbody.add_body().add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="wedge")
    return spec


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
@pytest.mark.parametrize("kind", ["SHELL", "CONVEX"])
def test_a_mesh_in_a_file_compiles_to_the_same_numbers(form: dict[str, Any], kind: str) -> None:
    inertia = getattr(mujoco.mjtMeshInertia, f"mjMESH_INERTIA_{kind}")
    plain, filed = spec_of(form, inertia), spec_of(form, inertia)
    file_assets(filed)
    assert is_name(filed.mesh("wedge").file)
    assert differing_arrays(plain.compile(), filed.compile()) == []
    points, faces = points_and_faces(filed, filed.mesh("wedge"))
    assert points.ravel().tolist() == POINTS
    assert faces.ravel().tolist() == form.get("userface", [])


def test_a_mesh_that_no_file_can_have_stays_in_the_spec() -> None:
    spec = spec_of(FORMS["triangles"] | {"usernormal": NORMALS[:9], "userfacenormal": [0] * 12})
    file_assets(spec)
    assert spec.mesh("wedge").file == ""
    points, faces = points_and_faces(spec, spec.mesh("wedge"))
    assert (len(points), len(faces)) == (4, 4)


def test_images_are_named_by_their_content() -> None:
    spec: Any = mujoco.MjSpec()
    _, image = cv2.imencode(".png", np.full((2, 3, 3), 7, np.uint8))
    spec.assets = {"wood.png": image.tobytes(), "other.xml": b"<mujoco/>"}
    for name in ("first", "second"):
        spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, file="wood.png")
    file_assets(spec)
    first, second = (texture.file for texture in spec.textures)
    assert first == second != "wood.png"
    assert set(spec.assets) == {first, "other.xml"}
    assert spec.compile().tex_data.tolist() == [7] * 36


def stored(world: World | None = None) -> int:
    """Bytes that MuJoCo keeps of processed files, when the world's edits are compiled."""
    assert world is None or world.sim.model.nbody
    return mujoco.mj_getCacheSize(mujoco.mj_getCache())


def test_a_mesh_is_processed_once_however_often_a_scene_is_edited_or_loaded() -> None:
    mujoco.mj_clearCache(mujoco.mj_getCache())
    world = World(WEDGE.format(1, 1))
    after_loading = stored(world)
    assert after_loading > 0
    editing.create_dummy(world.sim, 0.1)
    creating.create_primitive(world.parts, "cuboid", [0.1] * 3, creating.Body())
    World(WEDGE.format(1, 2))
    assert stored(world) == after_loading
    creating.create_primitive(world.parts, "cone", [0.1] * 3, creating.Body())
    after_cone = stored(world)
    creating.create_primitive(world.parts, "cone", [0.1] * 3, creating.Body())
    assert stored(world) == after_cone > after_loading


def test_a_full_store_is_emptied_so_that_it_takes_new_meshes() -> None:
    store = mujoco.mj_getCache()
    capacity = mujoco.mj_getCacheCapacity(store)
    try:
        mujoco.mj_clearCache(store)
        load_text(WEDGE.format(3, 1))
        one = stored()
        mujoco.mj_setCacheCapacity(store, one + one // 10)
        load_text(WEDGE.format(4, 1))
        assert stored() == one
    finally:
        mujoco.mj_setCacheCapacity(store, capacity)


def test_files_in_memory_keep_their_names_in_a_loaded_model(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(WEDGE.format(5, 1), encoding="utf-8")
    world = World("<mujoco><worldbody><body name='box'><geom size='1'/></body></worldbody></mujoco>")
    handles = [models.load_model(world.parts, tmp_path / "model.xml") for _ in range(3)]
    spec = world.sim.scene.spec
    assert len(set(handles)) == 3
    assert len(spec.meshes) == 1
    assert set(spec.assets) == {spec.meshes[0].file}


def test_a_kept_moment_has_the_meshes_of_its_scene() -> None:
    scene, model = load_text(WEDGE.format(6, 1))
    again, same = unpack_model(pack_model(scene, model))
    assert differing_arrays(model, same) == []
    assert differing_arrays(model, again.files.compile(again.spec.copy())) == []
