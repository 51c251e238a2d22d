"""Robots in URDF as they are found in ROS packages, small: an arm with meshes, a robot on wheels, a gripper."""

from __future__ import annotations

from pathlib import Path

TETRAHEDRON = "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

INERTIAL = (
    '<inertial><origin xyz="0 0 0.05"/><mass value="{mass}"/>'
    '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>'
)


def _link(name: str, mass: float, visual: str, collision: str) -> str:
    return f"""
  <link name="{name}">
    {INERTIAL.format(mass=mass)}
    <visual><geometry><mesh filename="{visual}"/></geometry><material name="steel"/></visual>
    <collision><geometry><mesh filename="{collision}"/></geometry></collision>
  </link>"""


def arm(
    scheme: str = "package://my_arm_description", visual_ending: str = "obj", collision_ending: str = "obj"
) -> str:
    """An arm of four links, whose joints reach from a `world` link; the third may not be at 0."""
    links = "".join(
        _link(
            name,
            mass,
            f"{scheme}/meshes/visual/{name}.{visual_ending}",
            f"{scheme}/meshes/collision/{name}.{collision_ending}",
        )
        for name, mass in (("base_link", 4), ("shoulder_link", 3), ("upper_arm_link", 2), ("forearm_link", 1))
    )
    return f"""<?xml version="1.0"?>
<robot name="my_arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <material name="steel"><color rgba="0.6 0.6 0.7 1"/></material>
  <link name="world"/>
  <joint name="world_joint" type="fixed"><parent link="world"/><child link="base_link"/></joint>{links}
  <joint name="shoulder_pan_joint" type="revolute">
    <parent link="base_link"/><child link="shoulder_link"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="-6.28" upper="6.28" effort="150" velocity="3.15"/><dynamics damping="0.1" friction="0"/>
  </joint>
  <joint name="shoulder_lift_joint" type="revolute">
    <parent link="shoulder_link"/><child link="upper_arm_link"/>
    <origin xyz="0 0 0.1" rpy="0 0 1.5708"/><axis xyz="0 1 0"/>
    <limit lower="-6.28" upper="6.28" effort="150" velocity="3.15"/>
  </joint>
  <joint name="elbow_joint" type="revolute">
    <parent link="upper_arm_link"/><child link="forearm_link"/><origin xyz="0 0 0.3"/><axis xyz="0 2 0"/>
    <limit lower="-3.0" upper="-0.5" effort="28" velocity="3.2"/>
  </joint>
  <link name="tool0"/>
  <joint name="tool0_joint" type="fixed">
    <parent link="forearm_link"/><child link="tool0"/><origin xyz="0 0 0.3"/>
  </joint>
  <transmission name="t"><type>transmission_interface/SimpleTransmission</type></transmission>
  <gazebo reference="base_link"><selfCollide>true</selfCollide></gazebo>
</robot>
"""


def write_arm(folder: Path, text: str | None = None, ending: str = "obj") -> Path:
    """The arm as a ROS package: `my_arm_description/urdf/my_arm.urdf` and its meshes."""
    package = folder / "my_arm_description"
    for kind, size in (("visual", 0.12), ("collision", 0.1)):
        (package / "meshes" / kind).mkdir(parents=True)
        for name in ("base_link", "shoulder_link", "upper_arm_link", "forearm_link"):
            (package / "meshes" / kind / f"{name}.{ending}").write_text(TETRAHEDRON.format(size))
    (package / "package.xml").write_text("<package><name>my_arm_description</name></package>")
    (package / "urdf").mkdir()
    file = package / "urdf" / "my_arm.urdf"
    file.write_text(arm() if text is None else text)
    return file


DIFFERENTIAL = """
<robot name="diffbot">
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed"><parent link="base_footprint"/><child link="base_link"/></joint>
  <link name="base_link">
    <inertial><mass value="5"/><inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial>
    <visual><geometry><box size="0.3 0.2 0.08"/></geometry></visual>
    <collision><geometry><box size="0.3 0.2 0.08"/></geometry></collision>
  </link>
  <link name="caster">
    <inertial><mass value="0.1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
    <collision><geometry><sphere radius="0.03"/></geometry></collision>
  </link>
  <joint name="caster_joint" type="fixed">
    <parent link="base_link"/><child link="caster"/><origin xyz="-0.12 0 -0.05"/>
  </joint>
  <link name="left_wheel">
    <inertial><mass value="0.3"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
    <collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.08" length="0.03"/></geometry></collision>
  </link>
  <link name="right_wheel">
    <inertial><mass value="0.3"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/></inertial>
    <collision><origin rpy="1.5708 0 0"/><geometry><cylinder radius="0.08" length="0.03"/></geometry></collision>
  </link>
  <joint name="left_wheel_joint" type="continuous">
    <parent link="base_link"/><child link="left_wheel"/><origin xyz="0.05 0.13 0"/><axis xyz="0 1 0"/>
    <limit effort="10" velocity="20"/>
  </joint>
  <joint name="right_wheel_joint" type="continuous">
    <parent link="base_link"/><child link="right_wheel"/><origin xyz="0.05 -0.13 0"/><axis xyz="0 1 0"/>
    <limit effort="10" velocity="20"/>
  </joint>
</robot>
"""

GRIPPER = """
<robot name="gripper">
  <link name="palm">
    <inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
  </link>
  <link name="left_finger">
    <inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
    <collision><geometry><box size="0.01 0.02 0.06"/></geometry></collision>
  </link>
  <link name="right_finger">
    <inertial><mass value="0.1"/><inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
    <collision><geometry><box size="0.01 0.02 0.06"/></geometry></collision>
  </link>
  <joint name="left_finger_joint" type="prismatic">
    <parent link="palm"/><child link="left_finger"/><origin xyz="0.02 0 0.09"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="0.04" effort="20" velocity="0.2"/>
  </joint>
  <joint name="right_finger_joint" type="prismatic">
    <parent link="palm"/><child link="right_finger"/><origin xyz="-0.02 0 0.09"/><axis xyz="1 0 0"/>
    <limit lower="-0.04" upper="0" effort="20" velocity="0.2"/>
    <mimic joint="left_finger_joint" multiplier="-1"/>
  </joint>
</robot>
"""
