"""A small scene with one child script, for the tests of the functions of ``sim``: Lua text in, its values out.

Everything goes the public way, through the script interpreter and `simxCallScriptFunction`; the values come back as a
Python literal that the script writes.
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Any

import pytest
from handler_calls import World

from simx_server.errors import CommandError

SCENE = """
<mujoco model="workshop">
  <compiler angle="radian"/>
  <option timestep="0.005" gravity="0 0 0"/>
  <worldbody>
    <body name="robot" pos="0 0 1">
      <geom type="box" size="0.1 0.2 0.3" mass="2"/>
      <site name="mark" pos="0.1 0.2 0.3" euler="0 0 1.5707963267948966"/>
      <body name="arm" pos="0 0 0.3">
        <joint name="hinge" axis="0 0 1" range="-2 2" limited="true"/>
        <geom type="box" size="0.05 0.05 0.05" pos="0.2 0 0" mass="0.5" contype="0" conaffinity="0"/>
        <site name="tip" pos="0.4 0 0"/>
        <camera name="eye" pos="0.4 0 0" resolution="8 4"/>
      </body>
    </body>
    <body name="cube" pos="2 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="0.5"/></body>
    <body name="cube#0" pos="3 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="0.5"/></body>
    <body name="wall" pos="0 -3 0.5"><geom type="box" size="0.5 0.05 0.5"/></body>
    <site name="ray" pos="0 -2 0.5" euler="1.5707963267948966 0 0"/>
  </worldbody>
  <sensor><rangefinder site="ray"/></sensor>
  <actuator><velocity name="motor" joint="hinge" kv="20"/></actuator>
  <custom>
    <text name="simx:joint:hinge" data="control=position P=0.1 upper_velocity=3 max_force=100 cyclic=no"/>
    <text name="simx:model:robot" data="base=yes"/>
  </custom>
</mujoco>
"""
"""Nothing falls. Objects: robot (mark, hinge (arm (tip, eye))), cube, cube#0, wall, ray."""

_SCRIPT = r"""
local function literal(value)
    local kind = math.type(value) or type(value)
    if kind == "nil" then return "None" end
    if kind == "boolean" then return value and "True" or "False" end
    if kind == "integer" then return tostring(value) end
    if kind == "float" then
        if value ~= value or value == math.huge or value == -math.huge then return "'" .. tostring(value) .. "'" end
        return string.format("%.17g", value):gsub("^(-?%d+)$", "%1.0")
    end
    if kind == "string" then
        return "'" .. value:gsub(".", function(c) return string.format("\\x%02x", c:byte()) end) .. "'"
    end
    if kind ~= "table" then return "'a " .. kind .. "'" end
    local parts, count = {}, #value
    for i = 1, count do parts[i] = literal(value[i]) end
    local list = "[" .. table.concat(parts, ",") .. "]"
    parts = {}
    for key, item in pairs(value) do
        if not (math.type(key) == "integer" and key >= 1 and key <= count) then
            parts[#parts + 1] = literal(key) .. ":" .. literal(item)
        end
    end
    if #parts == 0 then return list end
    for i = 1, count do parts[#parts + 1] = i .. ":" .. literal(value[i]) end
    return "{" .. table.concat(parts, ",") .. "}"
end

function evaluate(ints, floats, strings, source)
    local results = table.pack(assert(load(source, "=snippet"))())
    local texts = {}
    for i = 1, results.n do texts[i] = literal(results[i]) end
    return {}, {}, {}, "[" .. table.concat(texts, ",") .. "]"
end
"""


class ScriptWorld(World):
    """A running simulation in which one object has a child script that evaluates what the test says."""

    def __init__(self, folder: Path, xml: str = SCENE, owner: str = "robot", kind: str = "child") -> None:
        """`owner`: the name of the object the script belongs to; `kind`: child or customization.

        Its file is written to `folder`.
        """
        pytest.importorskip("lupa")
        (folder / "host.lua").write_text(_SCRIPT, encoding="utf-8")
        note = (
            f'<custom><text name="simx:script:{owner}" data="file=host.lua type={kind}"/></custom></mujoco>'
        )
        (folder / "scene.xml").write_text(xml.replace("</mujoco>", note), encoding="utf-8")
        super().__init__(file=folder / "scene.xml", workspace=folder)
        self.owner = owner
        self._type = {"child": 1, "customization": 6}[kind]
        self.scene_file = folder / "scene.xml"
        self.run(0)

    def lua(self, source: str) -> list[Any]:
        """All that a piece of Lua returns: tables as lists or dicts, strings with one character for each byte.

        Raises:
            CommandError: what the piece raised.
        """
        buffer = self.call(
            "simxCallScriptFunction", self.owner, self._type, "evaluate", [], [], [], source.encode("utf-8")
        )[3]
        return ast.literal_eval(buffer.decode("latin-1"))

    def value(self, source: str) -> Any:
        """The first result of a Lua expression."""
        (found,) = self.lua(f"return ({source})")
        return found

    def fails(self, source: str, match: str) -> None:
        """The piece must raise an error that says this (a regular expression)."""
        with pytest.raises(CommandError, match=match):
            self.lua(source)

    def goes_on(self, call: str, text: str, result: Any = None) -> None:
        """The call must give this result, and the status bar must say what it cannot do, once."""
        for _ in range(2):
            assert (self.lua(f"return {call}") or [None])[0] == result
        assert sum(text in message for message in self.parts.status_bar.messages) == 1

    def passes(self, count: int = 1) -> None:
        """Let the simulation go on."""
        for _ in range(count):
            self.parts.step()


@pytest.fixture
def world(tmp_path: Path) -> ScriptWorld:
    """To be imported by the tests that use it."""
    return ScriptWorld(tmp_path)
