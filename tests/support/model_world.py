"""A world whose object model is called directly."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from handler_calls import World
from sim_api_calls import SCENE

from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces
from simx_server.sim_api.object_model.dispatch import call_method
from simx_server.sim_api.object_model.values import Ref

SCENE_HANDLE, APP_HANDLE = -12, -13

ARM = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="base">
      <geom size="0.1"/>
      <body name="upper" pos="0 0 0.2">
        <joint name="shoulder" axis="0 1 0" range="-7 7" limited="true"/>
        <geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>
        <body name="lower" pos="0.5 0 0">
          <joint name="elbow" axis="0 1 0" range="-3 3" limited="true"/>
          <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.02"/>
          <site name="tip" pos="0.4 0 0"/>
        </body>
      </body>
    </body>
    <site name="target" pos="0.5 0 0.6"/>
    <body name="apart" pos="3 0 0"><joint name="other" axis="0 0 1"/><geom size="0.1"/></body>
  </worldbody>
  <custom>
    <text name="simx:joint:shoulder" data="mode=passive"/>
    <text name="simx:joint:elbow" data="mode=passive"/>
  </custom>
</mujoco>
"""
"""An arm with two hinges that moves its tip in the plane of x and z, and a target."""


class Model(World):
    """A world and a caller of its object model."""

    def __init__(self, xml: str, **named: Any) -> None:
        super().__init__(xml, **named)
        self.script = Script(4_000_000, ScriptKind.CUSTOMIZATION, -1, "client", full_results=True)
        self.api = Namespaces(self.parts, self.script).space("sim")

    def do(self, target: str | int | Ref, method: str, *arguments: Any) -> Any:
        """Call a method of an object, given by its path, handle or reference."""
        if isinstance(target, str):
            target = {"scene": SCENE_HANDLE, "app": APP_HANDLE}.get(target) or self.at(target).handle
        handle = target.handle if isinstance(target, Ref) else target
        return call_method(self.api, self.parts, self.script, handle, method, list(arguments))

    def at(self, path: str) -> Ref:
        (found,) = self.do("scene", "getObject", path)
        return found

    def get(self, target: str | int | Ref, name: str) -> Any:
        (found,) = self.do(target, "getProperty", name)
        return found

    def set(self, target: str | int | Ref, name: str, value: Any) -> None:
        self.do(target, "setProperty", name, value)


@pytest.fixture
def model(tmp_path: Path) -> Model:
    """To be imported by the tests that use it."""
    return Model(SCENE, workspace=tmp_path)
