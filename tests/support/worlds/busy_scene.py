"""A scene with what determinism may break on: contacts, a camera, threads that never wait, random numbers."""

from __future__ import annotations

BUSY = """
<mujoco>
  <worldbody>
    <camera name="eye" pos="0 -2 1" xyaxes="1 0 0 0 0.4 1" resolution="32 24"/>
    <geom type="plane" size="5 5 0.1"/>
    <body name="arm" pos="0 0 1">
      <joint name="hinge" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.02"/>
      <body name="hand" pos="0 0 -0.4">
        <joint name="wrist" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02"/>
      </body>
    </body>
    <body name="ball" pos="0.3 0 0.2"><freejoint/><geom size="0.05" mass="0.1"/></body>
  </worldbody>
  <custom>
    <text name="simx:lua:arm" data="
      -- A thread that never waits: when it gives way decides how far it counts in a pass.
      function sysCall_thread()
          local hinge, count = sim.getObject('/hinge'), 0
          while not sim.getThreadExistRequest() do
              count = count + 1
              sim.setJointTargetVelocity(hinge, math.sin(0.01 * count) + 0.1 * math.random() + 0.1 * sim.getRandom())
          end
      end"/>
    <text name="simx:python:hand" data="
      def sysCall_thread():
          import random
          sim.setThreadSwitchTiming(1)
          wrist, count = sim.getObject('/wrist'), 0
          while not sim.getThreadExistRequest():
              count += 1
              sim.setJointTargetVelocity(wrist, 0.001 * count * random.random())
              sim.setInt32Signal('count', count)"/>
  </custom>
</mujoco>
"""
