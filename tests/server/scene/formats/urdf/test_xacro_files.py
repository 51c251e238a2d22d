"""xacro files become robots without ROS: packages, arguments, included files; and only the operator's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from handler_calls import World

from simx_client.protocol.cli.installing import extra_line
from simx_server.app.scene_sources import sources_of
from simx_server.errors import CommandError
from simx_server.recording.scene_files import files_of
from simx_server.scene.finding.client_files import ClientFiles
from simx_server.scene.formats.annotations import SceneError
from simx_server.scene.formats.loader import load_scene
from simx_server.scene.formats.sources import Sources
from simx_server.scene.formats.urdf import xacro_files
from simx_server.scene.trial.gathering import gather
from simx_server.settings.settings import Settings

pytest.importorskip("xacro", reason=extra_line("urdf"))

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="bot">'

TOP = f"""<?xml version="1.0"?>{HEAD}
  <xacro:arg name="arms" default="1"/>
  <xacro:arg name="tool" default=""/>
  <xacro:include filename="$(find bot_parts)/urdf/arm.xacro"/>
  <xacro:property name="sizes" value="${{xacro.load_yaml('$(find bot_parts)/config/sizes.yaml')}}"/>
  <link name="base">
    <inertial><mass value="${{sizes['mass']}}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.2 0.2 ${{2 * sizes['half']}}"/></geometry></collision>
  </link>
  <xacro:arm number="1"/>
  <xacro:if value="${{$(arg arms) > 1}}"><xacro:arm number="2"/></xacro:if>
  <xacro:if value="${{'$(arg tool)' != ''}}">
    <xacro:include filename="$(find tool_of_others)/tool.xacro"/>
  </xacro:if>
</robot>"""

ARM = f"""{HEAD}
  <xacro:macro name="arm" params="number">
    <link name="arm_${{number}}">
      <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><mesh filename="package://bot_parts/meshes/arm.obj"/></geometry></collision>
    </link>
    <joint name="joint_${{number}}" type="continuous">
      <parent link="base"/><child link="arm_${{number}}"/><origin xyz="0 ${{number}} 0.3"/><axis xyz="0 0 1"/>
    </joint>
  </xacro:macro>
</robot>"""

TETRAHEDRON = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def sources(*packages: str, **arguments: str) -> Sources:
    return Sources.of(packages, {}, arguments)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A robot of two packages: `bot_description` has the robot, `bot_parts` beside it has the rest."""
    parts = tmp_path / "bot_parts"
    for folder in ("urdf", "config", "meshes"):
        (parts / folder).mkdir(parents=True)
    (parts / "package.xml").write_text("<package><name>bot_parts</name></package>")
    (parts / "urdf" / "arm.xacro").write_text(ARM)
    (parts / "config" / "sizes.yaml").write_text("mass: 3\nhalf: 0.1\n")
    (parts / "meshes" / "arm.obj").write_text(TETRAHEDRON)
    (tmp_path / "bot_description" / "urdf").mkdir(parents=True)
    file = tmp_path / "bot_description" / "urdf" / "bot.urdf.xacro"
    file.write_text(TOP)
    return file


def test_xacro_is_expanded_with_packages_macros_and_yaml(file: Path) -> None:
    scene, model = load_scene(file, sources())
    assert model.body("base").mass == 3
    assert model.geom("~geom1").size[2] == pytest.approx(0.1)
    assert scene.by_name("joint_1") is not None
    assert scene.by_name("joint_2") is None


@pytest.mark.parametrize(
    ("text", "is_xacro"),
    [
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/><link name="a"/></robot>', True),
        ('<robot><xacro:arm/><link name="a"/></robot>', True),
        ('<robot><link name="a"><inertial><mass value="${m}"/></inertial></link></robot>', True),
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a"/></robot>', False),
    ],
)
def test_xacro_is_recognised_without_its_ending(text: str, is_xacro: bool) -> None:
    assert xacro_files.is_xacro(text.encode(), "robot.urdf") is is_xacro
    assert xacro_files.is_xacro(text.encode(), "robot.xacro")


def test_arguments_are_given(file: Path) -> None:
    scene, _ = load_scene(file, sources(arms="2"))
    assert scene.by_name("joint_2") is not None


def test_package_elsewhere_is_named_by_a_flag(file: Path, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="start the server with --package tool_of_others=DIR"):
        load_scene(file, sources(tool="yes"))
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "tool.xacro").write_text(f'{HEAD}<link name="tool"/></robot>')
    text = TOP.replace(
        "</robot>", '<joint name="t" type="fixed"><parent link="base"/><child link="tool"/></joint></robot>'
    )
    file.write_text(text)
    scene, _ = load_scene(file, sources(f"tool_of_others={tmp_path / 'other'}", tool="yes"))
    assert scene.by_name("tool") is not None


@pytest.mark.parametrize(
    ("before", "after", "told"),
    [
        ("$(arg arms) > 1", "$(arg legs) > 1", r"legs.*--xacro NAME:=VALUE"),
        ('<xacro:arm number="1"/>', "<xacro:leg/>", "leg"),
        ("urdf/arm.xacro", "urdf/leg.xacro", "leg.xacro"),
        ("${2 * sizes['half']}", "${1 / 0}", "division by zero"),
        ("${2 * sizes['half']}", "${().__class__}", "__class__"),
        ("</robot>", "", "cannot expand"),
        ("$(find bot_parts)/urdf/arm.xacro", "bot.urdf.xacro", "includes itself"),
    ],
)
def test_error_in_xacro_is_told(file: Path, before: str, after: str, told: str) -> None:
    assert before in TOP
    file.write_text(TOP.replace(before, after, 1))
    with pytest.raises(SceneError, match=told):
        load_scene(file, sources())


def test_xacro_file_without_a_robot_is_told_as_other_texts(file: Path) -> None:
    file.write_text("")
    with pytest.raises(SceneError, match="it is empty; a scene in XML is MJCF or URDF"):
        load_scene(file, sources())


def test_entities_are_refused_in_included_files_too(file: Path) -> None:
    bomb = '<!DOCTYPE r [<!ENTITY a "aaaa">]>'
    arm = file.parents[2] / "bot_parts" / "urdf" / "arm.xacro"
    arm.write_text(bomb + ARM)
    with pytest.raises(SceneError, match=r"'arm.xacro' declares XML entities"):
        load_scene(file, sources())
    file.write_text(TOP.replace('<?xml version="1.0"?>', bomb))
    with pytest.raises(SceneError, match=r"'bot.urdf.xacro' declares XML entities"):
        load_scene(file, sources())


def test_without_the_library_the_error_says_how_to_install_it(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(xacro_files, "is_available", lambda: False)
    with pytest.raises(SceneError, match=r"ROS's library expands those: .*install.*xacro"):
        load_scene(file, sources())


def test_a_recording_takes_every_file_of_a_xacro_file(file: Path) -> None:
    names = {path.name for path in files_of(file, sources())}
    assert {"bot.urdf.xacro", "arm.xacro", "sizes.yaml", "arm.obj", "package.xml"} <= names


def test_file_outside_the_open_folders_is_not_included(file: Path, tmp_path: Path) -> None:
    (tmp_path / "secret.yaml").write_text("mass: 1\nhalf: 1\n")
    file.write_text(TOP.replace("$(find bot_parts)/config/sizes.yaml", str(tmp_path / "secret.yaml")))
    load_scene(file, sources())
    confined = sources().confined([file.parent.parent, tmp_path / "bot_parts"])
    with pytest.raises(SceneError, match=r"secret.yaml"):
        load_scene(file, confined)


def test_clients_get_the_operators_xacro_files_and_not_their_own(file: Path, tmp_path: Path) -> None:
    world = World(workspace=tmp_path)
    found = world.call("simxLoadModel", "bot_description/urdf/bot.urdf.xacro", 0)
    assert world.sim.scene.get(found).name == "base"
    arm = tmp_path / "bot_parts" / "urdf" / "arm.xacro"
    data = ARM.replace("continuous", "fixed").encode()
    world.sim.files.client_files.note(arm, data)
    arm.write_bytes(data)
    with pytest.raises(CommandError, match="whose expressions are programs"):
        world.call("simxLoadModel", "bot_description/urdf/bot.urdf.xacro", 0)
    world.sim.files.client_files.note(file, TOP.encode() + b" ")
    file.write_bytes(TOP.encode() + b" ")
    with pytest.raises(CommandError, match="whose expressions are programs"):
        world.call("simxLoadModel", "bot_description/urdf/bot.urdf.xacro", 0)


def test_convert_and_other_commands_refuse_xacro_that_clients_stored(file: Path, tmp_path: Path) -> None:
    of_command = sources_of(Settings(workspace=tmp_path))
    load_scene(file, of_command)
    ClientFiles(tmp_path).note(file, TOP.encode() + b" ")
    file.write_bytes(TOP.encode() + b" ")
    with pytest.raises(SceneError, match="whose expressions are programs"):
        load_scene(file, of_command)


def test_a_trial_refuses_xacro_before_it_is_expanded(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xacro_files, "expand", lambda *_: pytest.fail("it is expanded"))
    with pytest.raises(CommandError, match="none with --check-files"):
        gather(file, replace(sources(), within=(file.parents[2],)))


def test_described_sources_have_the_arguments() -> None:
    described = sources(arms="2").described()
    assert Sources.described_as(described, Path).xacro_arguments == {"arms": "2"}
