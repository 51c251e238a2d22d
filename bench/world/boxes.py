"""Scenes of many boxes, static or with a free joint, for measurements of what grows with a scene."""

from __future__ import annotations

ROW = 50
"""Boxes in a row, two metres apart, so that none of them touches another."""

CAMERA = "bench_camera"


def boxes(static: int, free: int = 0, timestep: float = 0.01) -> str:
    """Return a scene: a floor, a camera, boxes b0, b1, ... that are fixed, and f0, f1, ... that lie on the floor."""
    bodies = "".join(
        f'<body name="{name}{place}" pos="{2 * (place % ROW)} {2 * (place // ROW) + shift} 0.1">{joint}'
        '<geom type="box" size=".1 .1 .1"/></body>'
        for name, count, joint, shift in (("b", static, "", 1), ("f", free, "<freejoint/>", 0))
        for place in range(count)
    )
    return (
        f'<mujoco><option timestep="{timestep}"/><size memory="1G"/><worldbody>'
        '<geom name="floor" type="plane" size="200 200 1"/>'
        f'<camera name="{CAMERA}" pos="10 -10 10" xyaxes="1 0 0 0 .7 .7"/>{bodies}</worldbody></mujoco>'
    )


MODEL = """
<mujoco>
  <worldbody>
    <body name="lamp"><geom size="0.1"/>
      <body name="head" pos="0 0 1"><joint name="neck"/><geom size="0.1"/></body>
    </body>
  </worldbody>
</mujoco>
"""
"""A small model to load into a scene."""
