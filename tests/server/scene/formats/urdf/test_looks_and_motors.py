"""Visuals of COLLADA files, Gazebo's colours and friction, transmissions, and which robots stand."""

from __future__ import annotations

import logging
from itertools import pairwise
from pathlib import Path

import cv2
import mujoco
import numpy as np
import pytest
from collada_files import BLUE, RED, collada
from handler_calls import World
from urdf_robots import arm, write_arm

from simx_client.protocol.cli.installing import extra_line
from simx_server.app import cli
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf.reading import read_urdf

pytest.importorskip("collada", reason=extra_line("urdf"))


def sources() -> Sources:
    return Sources.of((), {})


def spec_of(text: str) -> mujoco.MjSpec:
    return read_urdf(f'<robot name="r">{text}</robot>'.encode(), "r.urdf", None, sources())


def link(name: str, shape: str = "", *, mass: float = 1.0, inertia: float = 0.01, visual: str = "") -> str:
    moments = f'ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"'
    collision = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    inertial = f'<inertial><mass value="{mass}"/><inertia {moments}/></inertial>'
    return f'<link name="{name}">{inertial}{collision}{visual}</link>'


def joint(parent: str, child: str, kind: str = "continuous", *, at: str = "0 0 0", more: str = "") -> str:
    return (
        f'<joint name="to_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="0 1 0"/>{more}</joint>'
    )


BOX = '<box size="0.2 0.2 0.2"/>'


# --- meshes ---------------------------------------------------------------------------------------


@pytest.fixture
def painted(tmp_path: Path) -> Path:
    """An arm with COLLADA visuals, of which the base has an image, and COLLADA that collides."""
    file = write_arm(tmp_path, arm(visual_ending="dae", collision_ending="dae"))
    meshes = file.parents[1] / "meshes"
    for kind in ("visual", "collision"):
        for path in list((meshes / kind).iterdir()):
            image = "../map.png" if path.stem == "base_link" and kind == "visual" else ""
            path.with_suffix(".dae").write_text(collada(unit=0.1, image=image))
            path.unlink()
    pixels = np.zeros((8, 8, 3), np.uint8)
    pixels[:4] = (0, 255, 0)  # the upper half is green
    cv2.imwrite(str(meshes / "map.png"), pixels)
    return file


def test_visual_of_collada_has_a_geom_for_each_material(painted: Path) -> None:
    _, model = load_scene(painted, sources())
    body = model.body("forearm_link").id
    geoms = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] == body]
    seen = [geom for geom in geoms if not model.geom_contype[geom]]
    assert [tuple(model.geom_rgba[geom]) for geom in seen] == [RED, BLUE]
    assert len(geoms) == 3, "what collides stays one geom"
    assert model.body_mass[body] == 1, "that of the file: visuals weigh nothing"
    mesh = model.mesh(int(model.geom_dataid[seen[0]]))
    points = model.mesh_vert[mesh.vertadr[0] :][: mesh.vertnum[0]]
    widest = np.linalg.norm(points[:, None] - points, axis=2).max()
    assert widest == pytest.approx(0.1 * np.sqrt(2)), "the unit of the file is 0.1 m"


def test_image_of_collada_is_a_texture_with_v_upwards(painted: Path) -> None:
    _, model = load_scene(painted, sources())
    names = [model.texture(number).name for number in range(model.ntex)]
    texture = model.texture(names.index("urdf_texture0"))
    height, width = texture.height[0], texture.width[0]
    pixels = model.tex_data[texture.adr[0] :][: height * width * 3].reshape(height, width, 3)
    assert pixels[-1, 0].tolist() == [0, 255, 0], "the upper row is at v = 1"
    assert pixels[0, 0].tolist() == [0, 0, 0]
    materials = {int(model.geom_matid[geom]) for geom in range(model.ngeom)} - {-1}
    assert len(materials) == 4, "red, blue, the image, and the floor"


def test_painted_robot_is_written_as_a_folder(painted: Path, caplog: pytest.LogCaptureFixture) -> None:
    folder = painted.parents[2] / "written"
    assert cli.main([str(painted), "--save-mjcf", str(folder) + ".xml"]) == 1
    assert "--convert FOLDER" in caplog.text
    assert cli.main([str(painted), "--convert", str(folder)]) == 0
    _, model = load_scene(folder / "my_arm_scene.xml", sources())
    assert (folder / "textures" / "urdf_texture0.png").is_file()
    assert RED in {tuple(color) for color in model.geom_rgba}


def test_link_without_a_mass_gets_that_of_its_colliding_collada(painted: Path) -> None:
    text = painted.read_text()
    start, end = text.index("<inertial>"), text.index("</inertial>") + len("</inertial>")
    painted.write_text(text[:start] + text[end:])
    _, model = load_scene(painted, sources())
    assert model.body("base_link").mass == pytest.approx(1000 * 0.1**3 / 6, rel=1e-3)


def test_robot_of_a_client_with_collada_goes_through_its_trial(painted: Path) -> None:
    workspace = painted.parents[2]
    world = World(workspace=workspace)
    data = painted.read_bytes() + b"\n"
    world.sim.files.client_files.note(painted, data)
    painted.write_bytes(data)
    base = world.call("simxLoadModel", "my_arm_description/urdf/my_arm.urdf", 0)
    assert world.sim.scene.get(base).name == "base_link"
    assert RED in {tuple(color) for color in world.sim.model.geom_rgba}
    world.parts.trials.close()


def test_collada_of_a_client_may_not_name_an_image_elsewhere(
    painted: Path, caplog: pytest.LogCaptureFixture
) -> None:
    workspace = painted.parents[2] / "my_arm_description"
    outside = painted.parents[2] / "outside.png"
    (workspace / "meshes" / "map.png").rename(outside)
    for path in (workspace / "meshes" / "visual").iterdir():
        path.write_text(collada(image=str(outside)))
    world = World(workspace=workspace)
    world.call("simxLoadModel", "urdf/my_arm.urdf", 0)
    assert "urdf_texture0" not in {world.sim.model.texture(i).name for i in range(world.sim.model.ntex)}


# --- Gazebo ---------------------------------------------------------------------------------------


def test_gazebo_colours_apply_to_visuals_without_their_own() -> None:
    visual = f"<visual><geometry>{BOX}</geometry>{{}}</visual>"
    own = '<material name="m"><color rgba="0.1 0.2 0.3 1"/></material>'
    spec = spec_of(
        '<material name="known"><color rgba="0.5 0.6 0.7 1"/></material>'
        + link("a", visual=visual.format(""))
        + link("b", visual=visual.format(own))
        + link("c", visual=visual.format('<material name="known"/>'))
        + link("d", visual=visual.format('<material name="unknown"/>'))
        + joint("a", "b") + joint("a", "c") + joint("a", "d")
        + '<gazebo reference="a"><material>Gazebo/Orange</material></gazebo>'
        + "".join(f'<gazebo reference="{n}"><material>Gazebo/Red</material></gazebo>' for n in "bc")
        + '<gazebo reference="d"><visual><material><diffuse>0 1 0 0.5</diffuse></material></visual></gazebo>'
        + '<gazebo reference="lost"><material>Gazebo/NoSuchColour</material></gazebo>'
    )  # fmt: skip
    colors = {
        body.name: [round(float(c), 4) for c in body.geoms[0].rgba] for body in spec.bodies if body.geoms
    }
    assert colors == {
        "a": [1, 0.5088, 0.0468, 1],
        "b": [0.1, 0.2, 0.3, 1],
        "c": [0.5, 0.6, 0.7, 1],
        "d": [0, 1, 0, 0.5],
    }


def test_gazebo_friction_decides_alone() -> None:
    ball = '<sphere radius="0.1"/>'
    spec = spec_of(
        link("a", BOX) + link("b", ball) + link("c", ball) + joint("a", "b", at="1 0 0") + joint("a", "c", at="-1 0 0")
        + '<gazebo reference="b"><mu1>0.05</mu1><mu2>0.05</mu2></gazebo>'
        + '<gazebo reference="c"><mu1>1e15</mu1></gazebo>'
    )  # fmt: skip
    found = {
        body.name: (body.geoms[0].friction[0], body.geoms[0].priority) for body in spec.bodies if body.geoms
    }
    assert found == {"a": (1, 0), "b": (0.05, 1), "c": (10, 1)}


# --- motors ---------------------------------------------------------------------------------------

TRANSMISSION = (
    '<transmission name="t_{0}"><joint name="to_{0}"><hardwareInterface>hardware_interface/{1}JointInterface'
    "</hardwareInterface></joint></transmission>"
)
CONTROL = '<ros2_control name="c"><joint name="to_{0}"><command_interface name="{1}"/></joint></ros2_control>'


@pytest.mark.parametrize("form", [TRANSMISSION, CONTROL])
def test_transmissions_tell_which_joints_have_a_motor(form: str) -> None:
    interfaces = ("Velocity", "Position") if form is TRANSMISSION else ("velocity", "position")
    spec = spec_of(
        link("a", BOX) + link("wheel", BOX) + link("arm", BOX) + link("caster", BOX) + link("lift", BOX)
        + joint("a", "wheel", at="1 0 0") + joint("a", "arm", at="2 0 0") + joint("a", "caster", at="3 0 0")
        + joint("a", "lift", "prismatic", at="4 0 0", more='<limit lower="0" upper="1" effort="9" velocity="1"/>')
        + form.format("wheel", interfaces[0]) + form.format("arm", interfaces[1])
    )  # fmt: skip
    notes = {text.name: text.data for text in spec.texts}
    assert notes["simx:joint:to_wheel"].startswith("motor=on control=velocity")
    assert notes["simx:joint:to_arm"].startswith("motor=on control=position")
    assert notes["simx:joint:to_caster"].startswith("motor=off")
    assert notes["simx:joint:to_lift"].startswith("motor=on control=position")


def test_without_transmissions_every_joint_has_a_motor() -> None:
    spec = spec_of(link("a", BOX) + link("wheel", BOX) + joint("a", "wheel", at="1 0 0"))
    (note,) = [text.data for text in spec.texts if text.name == "simx:joint:to_wheel"]
    assert note.startswith("motor=on control=position")


def test_caster_without_a_motor_turns_freely(tmp_path: Path) -> None:
    text = (
        link("world") + link("a") + joint("world", "a") + link("caster") + joint("a", "caster")
        + TRANSMISSION.format("a", "Position")
    )  # fmt: skip
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{text}</robot>')
    world = World(file=tmp_path / "r.urdf")
    world.call("simxSetJointTargetPosition", world.handle("to_a"), 0.5)
    world.run(20)
    assert world.call("simxGetJointPosition", world.handle("to_a")) == pytest.approx(0.5, abs=1e-3)
    assert abs(world.call("simxGetJointPosition", world.handle("to_caster"))) > 0.1, "it stays behind"


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_joints_of_light_links_reach_their_targets(
    tmp_path: Path, damping: float, caplog: pytest.LogCaptureFixture
) -> None:
    """Three links of a gram carry a heavier tip, as in hands; their damping would stop them in a microsecond."""
    limit = f'<limit lower="-1" upper="1" effort="2" velocity="2"/><dynamics damping="{damping}"/>'
    names = ["world", "j1", "j2", "tip"]
    text = link("world") + link("j1", mass=1e-3, inertia=1e-6) + link("j2", mass=1e-3, inertia=1e-6)
    text += link("tip", mass=0.01, inertia=1e-3)
    for parent, child in pairwise(names):
        text += joint(parent, child, "revolute", at="0 0 0.02", more=limit)
    (tmp_path / "r.urdf").write_text(f'<robot name="r">{text}</robot>')
    with caplog.at_level(logging.INFO):
        world = World(file=tmp_path / "r.urdf")
    assert ("the damping of 'to_j1', 'to_j2', 'to_tip' is smaller" in caplog.text) is (damping > 0)
    assert "'to_j1', 'to_j2', 'to_tip' get inertia" in caplog.text
    world.call("simxSetJointTargetPosition", world.handle("to_j2"), 0.2)
    world.run(30)
    assert world.call("simxGetJointPosition", world.handle("to_j2")) == pytest.approx(0.2, abs=0.01)
    for name in ("to_j1", "to_tip"):
        assert world.call("simxGetJointPosition", world.handle(name)) == pytest.approx(0, abs=0.01)


# --- standing -------------------------------------------------------------------------------------


def is_free(spec: mujoco.MjSpec) -> bool:
    return any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in spec.joints)


FOOT = '<box size="0.2 0.1 0.02"/>'
LIMIT = '<limit lower="-1" upper="1" effort="100" velocity="2"/>'


def test_biped_on_flat_feet_is_free_though_they_are_not_below_its_middle() -> None:
    text = link("trunk", BOX, mass=5)
    for side, y in (("l", 0.1), ("r", -0.1)):
        text += link(f"{side}_foot", FOOT) + joint(
            "trunk", f"{side}_foot", "revolute", at=f"0.07 {y} -0.6", more=LIMIT
        )
    spec = spec_of(text)
    assert is_free(spec)
    assert spec.body("trunk").pos[2] == pytest.approx(0.61)


def test_hand_that_lies_on_its_palm_is_fixed() -> None:
    finger = '<box size="0.1 0.02 0.02"/>'
    text = link("palm", '<box size="0.2 0.2 0.02"/>', mass=2)
    for number, y in enumerate((-0.05, 0.05)):
        text += link(f"f{number}", finger) + joint(
            "palm", f"f{number}", "revolute", at=f"0.2 {y} 0", more=LIMIT
        )
    assert not is_free(spec_of(text))


def test_fixed_robot_is_lifted_onto_the_floor() -> None:
    text = link("base", BOX) + link("arm", BOX) + joint("base", "arm", "revolute", at="1 0 -0.4", more=LIMIT)
    spec = spec_of(text)
    assert not is_free(spec)
    assert spec.body("base").pos[2] == pytest.approx(0.5)
    spec = spec_of(text.replace('"base"', '"world"'))
    assert spec.body("arm").pos[2] == pytest.approx(0.1)
    assert spec.worldbody.geoms[0].pos[2] == pytest.approx(0.5)


@pytest.mark.parametrize(
    "inertia",
    [
        'ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="1e-6" ixz="1e-6" iyz="1e-6"',
        'ixx="-5e-20" iyy="-5e-20" izz="0" ixy="0" ixz="0" iyz="0"',
        'ixx="0" iyy="4e-18" izz="0" ixy="0" ixz="0" iyz="-2e-20"',
        'ixx="0.1" iyy="0" izz="0.1" ixy="0" ixz="0" iyz="0"',
    ],
)
def test_inertias_that_no_body_has_are_repaired(inertia: str) -> None:
    text = link("base", BOX) + joint("base", "odd", at="1 0 0")
    text += f'<link name="odd"><inertial><mass value="1"/><inertia {inertia}/></inertial></link>'
    model = spec_of(text).compile()
    assert (model.body("odd").inertia > 0).all()
