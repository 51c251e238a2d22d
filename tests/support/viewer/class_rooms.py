"""A class in a browser: its scene, its command in a process, and the browser."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from browsers import chromium
from classes import Class, running_class

if TYPE_CHECKING:
    from playwright.sync_api import Browser

SWING = """
<mujoco model="swing">
  <statistic center="0 0 0.6" extent="0.8"/>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="2 2 0.1" rgba="0.3 0.5 0.7 1"/>
    <body name="arm" pos="0 0 0.6">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.05" rgba="1 0.2 0.1 1"/>
    </body>
  </worldbody>
</mujoco>
"""


class Room:
    """A class whose seats have an arm that swings, and a browser."""

    def __init__(self, folder: Path, stack: ExitStack, *flags: object) -> None:
        scene = folder / "swing.xml"
        scene.write_text(SWING)
        self.simx: Class = stack.enter_context(running_class(scene, *flags))
        self.browser: Browser = stack.enter_context(chromium())
