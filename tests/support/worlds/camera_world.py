"""A small world for camera tests: what stands where in front of which camera."""

import mujoco

from simx_server.scene.cameras.image import CameraView

# The camera `front` stands at y = -2 and looks along +y: world x is to the right, world z is up.
SCENE = """
<mujoco>
  <visual><headlight ambient="0.5 0.5 0.5" diffuse="0.5 0.5 0.5" specular="0 0 0"/></visual>
  <worldbody>
    <geom name="red" type="sphere" size="0.1" pos="-0.4 0 0.3" rgba="1 0 0 1"/>
    <geom name="green" type="box" size="0.1 0.1 0.1" pos="0.4 0 -0.3" rgba="0 1 0 1"/>
    <geom name="wall" type="box" size="3 0.1 3" pos="0 2.1 0" rgba="0.4 0.4 1 1"/>
    <geom name="collision shape" group="3" type="box" size="0.2 0.2 0.2" rgba="1 1 1 1"/>
    <geom name="invisible" type="box" size="0.2 0.2 0.2" pos="0 -1 0" rgba="1 1 1 0"/>
    <site name="dummy" size="0.2" rgba="1 1 1 1"/>
    <camera name="front" pos="0 -2 0" xyaxes="1 0 0 0 0 1" fovy="10"/>
    <camera name="down" pos="0 0 3" fovy="10"/>
  </worldbody>
</mujoco>
"""
FRONT = CameraView(camera_id=0, width=160, height=120, fovy_deg=45.0, near=0.1, far=10.0)


def load(xml: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    model = mujoco.MjModel.from_xml_string(xml)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def pixel_of(view: CameraView, x: float, y: float, depth: float) -> tuple[int, int]:
    """Row (bottom first) and column of a point x to the right of the view axis and y above it."""
    half_width, half_height = view.half_extent()
    scale = 1.0 if view.orthographic_size is not None else depth
    column = (x / (half_width * scale) + 1) / 2 * view.width
    row = (y / (half_height * scale) + 1) / 2 * view.height
    return int(row), int(column)
