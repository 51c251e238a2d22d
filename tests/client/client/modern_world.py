"""A small scene with one of each kind of object, a modern client of it, and what that client sends."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from real_world import RealWorld

from simx_client.client import Client
from simx_client.connection.clients import CLIENTS
from simx_client.protocol.codec import decode_batch

SCENE = """
<mujoco>
  <statistic extent="1"/>
  <visual><map znear="0.1" zfar="5"/></visual>
  <worldbody>
    <light pos="0 0 4"/>
    <body name="red" pos="-0.5 0.3 0.5" mocap="true"><geom type="box" size="0.2 0.1 0.5" rgba="1 0 0 1"/></body>
    <body name="blue" pos="0.5 -0.3 0" mocap="true"><geom type="box" size="0.2 0.1 0.5" rgba="0 0 1 1"/></body>
    <camera name="above" pos="0 0 3" fovy="60" resolution="64 48"/>
    <camera name="plan" pos="0 0 3" projection="orthographic" fovy="2" resolution="64 48"/>
    <body name="arm" pos="0 3 1">
      <joint name="shoulder" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.05"/>
      <body name="hand" pos="0.5 0 0">
        <joint name="wrist" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.05"/>
        <site name="tip" pos="0.3 0 0"/>
      </body>
    </body>
    <body name="seer" pos="0 -3 1"><geom size="0.05"/><site name="eye" euler="0 90 0"/></body>
    <body name="wall" pos="1 -3 1" mocap="true"><geom type="box" size="0.1 1 1"/></body>
    <body name="wheel" pos="-5 0 1">
      <joint name="axle" axis="1 1 0"/><geom size="0.1" contype="0"/>
    </body>
    <body name="stand" pos="5 0 1"><geom size="0.05"/>
      <body name="weight" pos="0.2 0 0">
        <geom type="box" size="0.05 0.05 0.05" mass="2"/><site name="cell" pos="-0.2 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><position name="shoulder" joint="shoulder" kp="200" kv="40"/><velocity name="wrist" joint="wrist" kv="10"/>
    <velocity name="axle" joint="axle" kv="10"/>
  </actuator>
  <sensor><rangefinder site="eye"/><force site="cell"/><torque site="cell"/></sensor>
</mujoco>
"""


def open_world(folder: Path) -> RealWorld:
    """The scene in a separate world, without OpenGL where the environment says so."""
    (folder / "scene.xml").write_text(SCENE)
    return RealWorld(folder / "scene.xml")


def messages_of(client: Client) -> list[int]:
    """The number of calls in each message that a client sends from now on."""
    transport: Any = CLIENTS.by_id[client.id]._transport
    sizes: list[int] = []
    send = transport.send

    def counted(payload: bytes, deadline: float) -> None:
        sizes.append(len(decode_batch(payload).calls))
        send(payload, deadline)

    transport.send = counted
    return sizes
