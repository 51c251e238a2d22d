"""A spec that is added to another becomes what MuJoCo's own attachment makes of it, and leaves nothing behind."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import cv2
import mujoco
import numpy as np
import pytest
from handler_calls import World
from vrep_shapes import cube
from vrep_writer import VrepWriter

from simx_server.editing import copying, creating, models
from simx_server.scene.assets.filing import file_assets
from simx_server.scene.editing import editing
from simx_server.scene.editing.copies import joining
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.exporting.check import differing_arrays
from simx_server.scene.formats.loader import load_text, prepare

PART = """
<mujoco>
  <compiler angle="radian"/>
  <default>
    <geom friction="0.3 0.01 0.001"/><default class="thin"><geom density="10" rgba="1 0 0 1"/></default>
  </default>
  <asset>
    <texture name="wood" type="2d" file="wood.png"/>
    <material name="wood" texture="wood" specular="0.7"/><material name="plain" rgba="0 1 0 1"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 2"/>
    <mesh name="same" vertex="0 0 0  1 0 0  0 1 0  0 0 2"/>
    <mesh name="larger" vertex="0 0 0  1 0 0  0 1 0  0 0 2" scale="2 2 2"/>
    <hfield name="hill" nrow="2" ncol="3" size="1 1 1 0.1" elevation="0 1 2 3 4 5"/>
  </asset>
  <worldbody>
    <body name="base" pos="0.1 0.2 0.3" quat="0.6 0 0.8 0">
      <geom name="a" type="mesh" mesh="wedge" material="wood"/>
      <geom name="b" type="mesh" mesh="same" class="thin" pos="0 0 1"/>
      <geom name="h" type="hfield" hfield="hill"/>
      <site name="top" material="plain" pos="0 0 1"/>
      <camera name="eye" mode="targetbody" target="arm"/>
      <light name="lamp" diffuse="1 0 0"/>
      <frame pos="0 1 0" quat="0 1 0 0">
        <body name="arm" childclass="thin">
          <joint name="hinge" axis="0 1 0" range="-1 1"/>
          <geom name="c" type="mesh" mesh="larger" material="plain"/>
          <site name="tip" pos="1 0 0"/>
        </body>
      </frame>
    </body>
    <body name="free"><freejoint name="free"/><geom name="ball" size="0.1"/></body>
  </worldbody>
  <tendon><spatial name="rope" material="plain"><site site="top"/><site site="tip"/></spatial></tendon>
  <actuator><position name="servo" joint="hinge" kp="3"/></actuator>
  <sensor><jointpos joint="hinge"/><force site="tip"/></sensor>
  <equality><weld name="weld" body1="free" body2="arm"/></equality>
  <contact><exclude body1="base" body2="free"/><pair geom1="ball" geom2="a"/></contact>
  <custom><numeric name="simx:specular:wood" data="1 0.5 0.2"/><text name="note" data="kept"/></custom>
</mujoco>
"""

SCENE = """
<mujoco>
  <asset><mesh name="first" vertex="0 0 0  1 0 0  0 1 0  0 0 2"/></asset>
  <worldbody><body name="box"><geom name="box" type="mesh" mesh="first"/></body></worldbody>
</mujoco>
"""


def part_of() -> Any:
    spec: Any = mujoco.MjSpec.from_string(PART)
    _, image = cv2.imencode(".png", np.full((2, 3, 3), 7, np.uint8))
    spec.assets["wood.png"] = image.tobytes()
    prepare(spec)
    file_assets(spec)
    return spec


def joined(how: Any) -> Any:
    scene, _ = load_text(SCENE)
    spec: Any = scene.spec.copy()
    how(part_of(), spec, "7~")
    return spec


def test_copied_elements_compile_as_attached_ones() -> None:
    copied, attached = joined(joining._copy), joined(joining._attach)
    attached.dedup_assets()
    assert joining._can_be_copied(part_of(), copied)
    one, other = copied.copy().compile(), attached.copy().compile()
    assert differing_arrays(one, other) == []
    assert one.names == other.names
    assert one.text_data == other.text_data
    assert {mesh.name for mesh in copied.meshes} == {"first", "7~larger"}


@pytest.mark.parametrize(
    "option", ['inertiafromgeom="true"', 'boundmass="0.5"', 'autolimits="false"', 'balanceinertia="true"']
)
def test_a_part_that_is_compiled_in_another_way_is_attached(option: str) -> None:
    part: Any = mujoco.MjSpec.from_string(f"<mujoco><compiler {option}/></mujoco>")
    assert not joining._can_be_copied(part, mujoco.MjSpec())


def test_a_part_with_files_of_the_disk_is_attached() -> None:
    part: Any = mujoco.MjSpec()
    part.add_mesh(name="wedge", file="meshes/wedge.obj")
    assert not joining._can_be_copied(part, mujoco.MjSpec())


# --- what stays when objects go -----------------------------------------------------------------


def sizes(world: World) -> dict[str, int]:
    spec = world.sim.scene.spec
    kinds = ("bodies", "geoms", "frames", "meshes", "materials", "textures", "numerics", "texts")
    return {kind: len(getattr(spec, kind)) for kind in kinds} | {"assets": len(spec.assets)}


def test_removed_objects_leave_no_meshes_materials_images_or_frames(tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(
        PART.replace('file="wood.png"', 'builtin="flat" width="2" height="2"')
    )
    world = World("<mujoco><worldbody><body name='box'><geom size='1'/></body></worldbody></mujoco>")
    before = sizes(world)
    model = models.load_model(world.parts, tmp_path / "model.xml")
    creating.create_primitive(world.parts, "cone", [0.1] * 3, creating.Body())
    cuboid = creating.create_primitive(world.parts, "cuboid", [0.1] * 3, creating.Body())
    world.parts.shape_colors.set(cuboid, 2, [1.0, 0.0, 0.0])
    assert all(sizes(world)[kind] > before[kind] for kind in ("meshes", "materials", "textures", "numerics"))
    editing.remove_model(world.sim, model)
    for handle in world.sim.scene.children(-1):
        if handle != world.handle("box"):
            editing.remove_tree(world.sim, handle)
    assert sizes(world) == {**before, "texts": before["texts"] + 1}


def test_a_mesh_stays_while_another_object_has_it() -> None:
    world = World(SCENE)
    copy = copying.copy_objects(world.parts, [world.handle("box")])[0]
    editing.remove_object(world.sim, world.handle("box"))
    assert sizes(world)["meshes"] == 1
    editing.remove_object(world.sim, copy)
    assert sizes(world)["meshes"] == 0


# --- models of V-REP ----------------------------------------------------------------------------


def model_file(name: str = "block") -> bytes:
    writer = VrepWriter(21, is_model=True)
    points, faces = cube((0.2, 0.2, 0.4))
    writer.shape(name, mesh=(points, faces), dynamic=True, position=(2, 0, 0.3), model_base=True)
    return writer.bytes()


def test_a_model_that_is_loaded_again_is_not_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from simx_server.scene.formats import model_files

    read, path = [], tmp_path / "block.ttm"
    path.write_bytes(model_file())
    real = model_files.read_model
    monkeypatch.setattr(model_files, "read_model", lambda *given: read.append(given[0]) or real(*given))
    world = World("<mujoco/>", workspace=tmp_path)
    first, second = (world.call("simxLoadModel", "block.ttm", 0) for _ in range(2))
    assert read == [path]
    names = [world.sim.scene.get(handle).name for handle in (first, second)]
    assert names == ["block", "block#0"]
    assert all(world.sim.scene.is_model_base(handle) for handle in (first, second))
    assert len(world.sim.scene.spec.meshes) == 1
    path.write_bytes(model_file("brick"))
    third = world.call("simxLoadModel", "block.ttm", 0)
    assert world.sim.scene.get(third).name == "brick"
    assert read == [path, path]


LAMP = '<mujoco><worldbody><body name="lamp"><geom size="0.1"/></body>{}</worldbody></mujoco>'


@pytest.mark.parametrize(
    ("name", "text", "readings"),
    [
        ("whole.xml", LAMP.format(""), 1),
        (
            "parts.xml",
            LAMP.format('<body name="more"/>').replace(
                "<worldbody>", '<include file="more.xml"/><worldbody>'
            ),
            2,
        ),
        ("other.xml", "\ufeff" + LAMP.format(""), 2),
    ],
)
def test_a_text_is_read_again_if_it_names_files(
    name: str, text: str, readings: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from simx_server.scene.formats import kept_models, model_files

    (tmp_path / "more.xml").write_text("<mujoco><option timestep='0.01'/></mujoco>")
    path, read, real = tmp_path / name, [], model_files.read_model
    path.write_bytes(text.encode("utf-16-le" if text.startswith("\ufeff") else "utf-8"))
    monkeypatch.setattr(model_files, "read_model", lambda *given: read.append(given[0]) or real(*given))
    kept = kept_models.KeptModels()
    for _ in range(2):
        with contextlib.suppress(SceneError):
            kept.read(path)
    assert read == [path] * readings


def test_the_model_of_a_text_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from simx_server.scene.formats import kept_models

    path = tmp_path / "many.xml"
    path.write_text(
        LAMP.format('<replicate count="500" offset="1 0 0"><body><geom size="0.1"/></body></replicate>')
    )
    kept = kept_models.KeptModels()
    assert kept.read(path) is kept.read(path)
    monkeypatch.setattr(kept_models, "_MOST_BYTES", 100 * path.stat().st_size)
    small = kept_models.KeptModels()
    assert small.read(path) is not small.read(path)


def test_models_that_were_used_longest_ago_are_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from simx_server.scene.formats import kept_models

    data = model_file()
    monkeypatch.setattr(kept_models, "_MOST_BYTES", 2 * len(data))
    paths = [tmp_path / f"{number}.ttm" for number in range(3)]
    for path in paths:
        path.write_bytes(data)
    kept = kept_models.KeptModels()
    first, second = (kept.read(path) for path in paths[:2])
    assert kept.read(paths[0]) is first
    kept.read(paths[2])
    assert kept.read(paths[0]) is first
    assert kept.read(paths[1]) is not second
