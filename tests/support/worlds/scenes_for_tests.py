"""Small scenes for the tests of scene, joints and simulation: one idea each."""

from __future__ import annotations

from pathlib import Path

from simx_server.app.building import build_world
from simx_server.scene.formats.loader import load_text
from simx_server.world.world import World

ARM = """
<mujoco model="arm">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <light name="sun" pos="0 0 3" dir="0 0 -1"/>
    <camera name="overview" pos="0 -2 1" xyaxes="1 0 0 0 0.5 1"/>
    <body name="base" pos="0.5 0 0.1">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="upper" pos="0 0 0.1" gravcomp="1">
        <joint name="shoulder" axis="0 0 1" armature="0.1"/>
        <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="2" contype="0" conaffinity="0"/>
        <body name="lower" pos="0.4 0 0" gravcomp="1">
          <joint name="elbow" axis="0 1 0" range="-2 2" limited="true" armature="0.1"/>
          <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="1" contype="0" conaffinity="0"/>
          <site name="tip" pos="0.3 0 0"/>
          <camera name="eye" pos="0.3 0 0"/>
          <body name="hand" pos="0.3 0 0">
            <geom type="box" size="0.02 0.02 0.02" mass="0.1" contype="0" conaffinity="0"/>
            <body><site name="mount" pos="0.05 0 0"/></body>
          </body>
        </body>
      </body>
    </body>
    <body name="cube" pos="0 1 0.05"><freejoint/><geom type="box" size="0.05 0.05 0.05" mass="0.5"/></body>
    <body name="wall" pos="0 -1 0.5"><geom type="box" size="0.5 0.05 0.5"/></body>
  </worldbody>
  <sensor><force site="mount"/><torque site="mount"/></sensor>
  <actuator>
    <velocity name="m1" joint="shoulder" kv="200"/>
    <velocity name="m2" joint="elbow" kv="200"/>
  </actuator>
  <custom>
    <text name="simx:joint:shoulder" data="control=position P=0.1 upper_velocity=3 max_force=100 cyclic=no"/>
    <text name="simx:joint:elbow" data="control=position P=0.1 upper_velocity=3 max_force=100"/>
  </custom>
</mujoco>
"""

SLIDER = """
<mujoco model="slider">
  <option timestep="0.002" integrator="implicitfast" gravity="{gravity}"/>
  <worldbody>
    <body name="cart" gravcomp="{gravcomp}">
      <joint name="rail" type="{kind}" axis="0 0 1" {joint}/>
      <geom type="box" size="0.1 0.1 0.1" mass="1" pos="{offset} 0 0"/>
    </body>
  </worldbody>
  <actuator>{actuator}</actuator>
  <custom>{custom}<numeric name="simx:time_step" data="0.05"/></custom>
</mujoco>
"""


def arm() -> World:
    return world_of(ARM)


def slider(
    *,
    actuator: str = "",
    note: str | None = None,
    kind: str = "slide",
    joint: str = "",
    gravity: str = "0 0 -10",
    gravcomp: float = 0,
    offset: float = 0,
) -> World:
    """One body on one joint along or about z; `note`: the joint's annotation."""
    custom = f'<text name="simx:joint:rail" data="{note}"/>' if note is not None else ""
    return world_of(
        SLIDER.format(
            actuator=actuator,
            custom=custom,
            kind=kind,
            joint=joint,
            gravity=gravity,
            gravcomp=gravcomp,
            offset=offset,
        )
    )


def world_of(scene: str | Path, workspace: Path | None = None) -> World:
    """A whole world as the server has it, with a scene by its text or file; images are not rendered."""
    world = build_world(NoRendering(), workspace=workspace)  # type: ignore[arg-type]
    if isinstance(scene, Path):
        world.simulation.load(scene)
    else:
        world.simulation.use(*load_text(scene))
    return world


class NoRendering:
    """Stands in for the render thread."""


def run(world: World, steps: int) -> None:
    world.simulation.start()
    for _ in range(steps):
        world.step()
