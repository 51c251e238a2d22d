"""A whole server in the test's own thread that keeps past steps, and is driven step by step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from real_world import BLOCKING, RealWorld, handle_of

import simx_client as v
from simx_server.history import History
from simx_server.history.going_on import go_on
from simx_server.recording import state
from simx_server.simulation.simulation import SimulationState

MACHINE = """
<mujoco>
  <compiler angle="radian"/>
  <option integrator="implicitfast"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="arm" pos="0 0 1">
      <joint name="shoulder" axis="0 1 0" damping="0.2"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/>
      <body name="fore" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" range="-2 2" limited="true"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03"/>
        <site name="gauge" pos="0.3 0 0"/>
        <body name="hand" pos="0.3 0 0"><geom type="box" size="0.03 0.03 0.03"/></body>
      </body>
    </body>
    <body name="wheel" pos="1 1 0.5"><joint name="spin" axis="0 0 1"/>
      <geom type="cylinder" size="0.2 0.05"/></body>
    <body name="slide" pos="-1 0 0.2">
      <joint name="rail" type="slide" axis="1 0 0" range="-1 1" limited="true"/><geom type="box" size="0.1 0.1 0.1"/>
    </body>
    <body name="box" pos="0.3 0.5 0.8"><freejoint/><geom type="box" size="0.05 0.08 0.1"/></body>
    <body name="ball" pos="0.32 0.52 1.2"><freejoint/><geom type="sphere" size="0.06"/></body>
    <body name="post" pos="2 0 0.5"><geom name="post" type="box" size="0.1 0.1 0.5"/></body>
  </worldbody>
  <actuator>
    <motor name="shoulder" joint="shoulder"/><motor name="elbow" joint="elbow"/>
    <velocity name="spin" joint="spin" kv="1"/>
    <motor name="rail" joint="rail"/>
  </actuator>
  <sensor><force site="gauge"/><torque site="gauge"/></sensor>
  <custom>
    <text name="simx:joint:shoulder"
      data="mode=force motor=true control=position P=0.1 I=0.002 D=0.01 upper_velocity=3 max_force=60"/>
    <text name="simx:joint:elbow" data="mode=force motor=true control=position upper_velocity=2 max_force=20"/>
    <text name="simx:joint:rail" data="mode=motion target_velocity=0.1"/>
    <text name="simx:force:gauge" data="samples=3"/>
  </custom>
</mujoco>
"""
"""Position control with an integral and a derivative, velocity control, a joint in motion, free bodies in contact, a
force sensor with a filter over three steps."""


class Lab:
    """A world with a history, driven step by step."""

    def __init__(self, scene: str | Path) -> None:
        self.scene_path = str(scene)
        self.world = RealWorld(scene)
        self.loop, self.parts, self.sim = self.world.loop, self.world.parts, self.world.simulation
        self.history = History(self.loop.service, 60.0)
        self.loop.service.watchers.add(self.history)
        self.client = self.world.client()

    def start(self) -> None:
        """Start or continue; steps are made by `steps` alone."""
        assert v.simxSynchronous(self.client, True) == 0
        self.sim.start()

    def steps(self, count: int) -> None:
        for _ in range(count):
            assert self.sim.state is SimulationState.RUNNING
            self.parts.step()

    def run_to(self, step: int, act: Callable[[int], None] = lambda _step: None) -> list[list[bytes]]:
        """Go on to a step; return digests of everything after each step. `act` is called before each."""
        seen: list[list[bytes]] = []
        while self.sim.step_count < step:
            act(self.sim.step_count)
            self.steps(1)
            seen.append([*state.digests(self.parts), self.readings()])
        return seen

    def readings(self) -> bytes:
        """Values that clients read of objects: velocities, forces, positions."""
        values: list[Any] = []
        for handle, item in self.sim.scene.objects.items():
            values += self.parts.velocities.measure(handle)
            if item.kind.name == "FORCE_SENSOR":
                values.append(self.parts.force.read(handle))
            if item.kind.name == "JOINT":
                values.append(self.sim.joints.position(handle))
        values += [v.simxGetJointForce(self.client, h, BLOCKING) for h in self.joints()]
        values += [v.simxGetObjectFloatParameter(self.client, h, 2012, BLOCKING) for h in self.joints()]
        return repr(values).encode()

    def joints(self) -> list[int]:
        return v.simxGetObjects(self.client, v.sim_object_joint_type, BLOCKING)[1]

    def handle(self, name: str) -> int:
        return handle_of(self.client, name)

    def go_on(self, step: int) -> Any:
        gone = go_on(self.loop.service, self.history, step)
        assert self.sim.state is SimulationState.PAUSED
        assert self.sim.step_count == step
        return gone
