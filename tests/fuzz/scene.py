"""A small scene with one of everything that a call can be about, for calls that mean no good."""

from __future__ import annotations

SCRIPT = """
function returns(ints, floats, strings, buffer) return ints, floats, strings, buffer end
function nothing() end
function fails() error('on purpose') end
"""

SCENE = f"""<mujoco model="victim">
  <custom>
    <text name="simx:lua:base" data="{SCRIPT}"/>
    <text name="simx:collection:some" data="tree=base"/>
    <text name="simx:collision:hit" data="entity1=arm entity2=box"/>
    <text name="simx:distance:far" data="entity1=arm entity2=box"/>
    <text name="simx:model:base" data="base=yes"/>
  </custom>
  <worldbody>
    <light name="lamp" pos="0 0 3"/>
    <body name="base">
      <geom size=".1 .1 .1" type="box"/>
      <site name="dummy"/>
      <body name="arm" pos="0 0 .3">
        <joint name="hinge" range="-3 3" damping="1"/>
        <geom size=".05 .2" type="capsule"/>
        <camera name="eye" resolution="8 8" fovy="60"/>
        <site name="ray" zaxis="1 0 0"/>
        <site name="feel"/>
        <body name="slider" pos="0 0 .3">
          <joint name="slide" type="slide" range="-.1 .1" damping="1"/>
          <geom size=".05"/>
          <body name="knob"><joint name="ball" type="ball" damping="1"/><geom size=".02"/></body>
        </body>
      </body>
    </body>
    <body name="box" pos="1 0 1"><freejoint/><geom size=".1 .1 .1" type="box"/></body>
  </worldbody>
  <sensor>
    <rangefinder name="beam" site="ray"/>
    <force name="f" site="feel"/><torque name="t" site="feel"/>
  </sensor>
</mujoco>"""
