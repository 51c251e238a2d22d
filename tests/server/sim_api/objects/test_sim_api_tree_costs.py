"""Calls that a program makes for each object of a model do as much in a large model as in a small one."""

from __future__ import annotations

import gc
import sys
from typing import Any

import pytest
from handler_calls import World

from simx_client.protocol import constants as c
from simx_server.errors import UnknownName
from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces

SMALL, LARGE = 20, 200
UNKNOWN = "linkk_17"


class Program:
    """A program of PyRep with a model of links, every tenth of which is free, and a robot that carries its parts."""

    def __init__(self, links: int) -> None:
        parts = (
            f'<body name="link_{i}" pos="{i} 0 0">{"" if i % 10 else "<freejoint/>"}<geom size="0.1"/></body>'
            for i in range(links)
        )
        carried = "".join(f'<body name="part_{i}"><geom size="0.1"/></body>' for i in range(links))
        notes = (
            f'<text name="simx:object:link_{i}" data="parent=base layers=0x0001"/>' for i in range(links)
        )
        self.world = World(
            f"""
            <mujoco>
              <option gravity="0 0 0"/>
              <worldbody>
                <body name="base"><geom size="0.1"/><site name="tip"/></body>{"".join(parts)}
                <body name="robot"><geom size="0.1"/>{carried}</body>
              </worldbody>
              <custom>{"".join(notes)}<text name="simx:model:base" data="base=yes"/></custom>
            </mujoco>"""
        )
        self.world.run()
        self.namespaces = Namespaces(
            self.world.parts, Script(3_000_000, ScriptKind.CUSTOMIZATION, -1, "program")
        )

    def call(self, name: str, *arguments: Any) -> tuple[Any, ...]:
        found = self.namespaces.invoke(f"sim.{name}", list(arguments))
        assert isinstance(found, tuple)
        return found

    def calls_in(self, name: str, *arguments: Any) -> int:
        """Functions called in a call, MuJoCo's included, after two calls that may find things out."""
        count = 0

        def note(frame: object, event: str, argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        for _ in range(2):
            self.call(name, *arguments)
        gc.disable()
        sys.setprofile(note)
        try:
            self.call(name, *arguments)
        finally:
            sys.setprofile(None)
            gc.enable()
        return count


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("getObjectsInTree", ("base", c.sim_handle_all, 0)),
        ("getObjectName", ("link_5",)),
        ("getObjectHandle", ("=link_5",)),
        ("getObjectHandle", (f"={UNKNOWN}@silentError",)),
        ("getObjectType", ("link_5",)),
        ("getObjectParent", ("link_5",)),
        ("getModelProperty", ("base",)),
        ("resetDynamicObject", ("link_5",)),
        ("resetDynamicObject", ("link_10",)),
        ("resetDynamicObject", ("robot",)),
        ("setObjectPosition", ("tip", -1, [0.1, 0.2, 0.3])),
        ("setObjectPosition", ("link_5", -1, [0.1, 0.2, 0.3])),
        ("setObjectPosition", ("robot", -1, [0.1, 0.2, 0.3])),
        ("setObjectQuaternion", ("link_5", -1, [0.0, 0.0, 0.0, 1.0])),
        ("setObjectSpecialProperty", ("link_5", 0x3F2)),
    ],
)
def test_a_call_for_one_object_does_not_walk_through_its_model(name: str, arguments: tuple[Any, ...]) -> None:
    counts: list[int] = []
    for program in (Program(SMALL), Program(LARGE)):
        handle = program.world.handle
        given = [handle(each) if isinstance(each, str) and each[0] != "=" else each for each in arguments]
        given = [each[1:] if isinstance(each, str) else each for each in given]
        counts.append(program.calls_in(name, *given))
    small, large = counts
    assert large <= small + 2, counts


def test_resetting_takes_the_velocity_of_an_object_and_of_what_it_carries_alone() -> None:
    program = Program(SMALL)
    base, link, other = (program.world.handle(name) for name in ("base", "link_10", "link_0"))
    data = program.world.sim.data
    for handle, still in ((link, [link]), (base, [link, other])):
        data.qvel[:] = 1.0
        before = data.qpos.copy(), data.xpos.copy()
        program.call("resetDynamicObject", handle)
        for each in (link, other):
            body = program.world.sim.scene.objects[each].body
            first = int(program.world.sim.model.body_dofadr[body])
            assert (data.qvel[first : first + 6] == (0.0 if each in still else 1.0)).all()
        assert (data.qpos == before[0]).all(), "to the last bit"
        version = program.world.sim.version
        program.call("resetDynamicObject", link)
        assert program.world.sim.version == version, "nothing has changed"


def test_what_was_found_out_about_a_tree_ends_with_it() -> None:
    program = Program(SMALL)
    base, link, tip = (program.world.handle(name) for name in ("base", "link_5", "tip"))
    assert link in program.call("getObjectsInTree", base, c.sim_handle_all, 0)[0]
    program.call("setObjectPosition", base, -1, [0.0, 0.0, 1.0])
    assert program.call("getObjectPosition", link, -1)[0][2] == pytest.approx(1.0)
    program.call("setObjectParent", link, -1, True)
    assert link not in program.call("getObjectsInTree", base, c.sim_handle_all, 0)[0]
    program.call("setObjectPosition", base, -1, [0.0, 0.0, 2.0])
    assert program.call("getObjectPosition", link, -1)[0][2] == pytest.approx(1.0)
    program.call("setObjectParent", link, tip, True)
    program.call("setObjectPosition", tip, -1, [0.0, 0.0, 3.0])
    assert program.call("getObjectPosition", link, -1)[0][2] == pytest.approx(2.0)
    assert program.call("getObjectsInTree", tip, c.sim_object_shape_type, 1)[0] == [link]


def test_a_twin_of_a_scene_finds_things_out_about_its_own_tree() -> None:
    scene = Program(SMALL).world.sim.scene
    base, link = (scene.by_name(name) for name in ("base", "link_5"))
    assert base is not None
    assert link is not None
    twin = scene.twin()
    twin.override_parent(link, -1)
    assert link not in twin.descendants(base)
    assert link in scene.descendants(base)
    assert link not in twin.descendants(base)


def test_a_tree_may_be_deep() -> None:
    sites = "".join(f'<site name="s{i}"/>' for i in range(1500))
    world = World(f"<mujoco><worldbody>{sites}</worldbody></mujoco>")
    scene = world.sim.scene
    handles = [world.handle(f"s{i}") for i in range(1500)]
    scene.override_parents(dict(zip(handles[1:], handles, strict=False)))
    assert scene.descendants(handles[0]) == handles[1:]
    assert list(scene.leaves_first()) == handles[::-1]


def test_properties_of_models_reach_what_is_far_below() -> None:
    program = Program(SMALL)
    base, tip, link = (program.world.handle(name) for name in ("base", "tip", "link_5"))
    program.call("setObjectParent", link, tip, True)
    scene = program.world.sim.scene
    program.call("setModelProperty", base, c.sim_modelproperty_not_measurable)
    assert scene.overridden(link) == scene.overridden(tip) == c.sim_modelproperty_not_measurable
    program.call("setModelProperty", base, 0)
    assert scene.overridden(link) == 0


def test_a_call_that_fails_leaves_nothing_for_the_garbage_collector() -> None:
    namespaces = Namespaces(
        Program(SMALL).world.parts,
        Script(3_000_000, ScriptKind.CUSTOMIZATION, -1, "program", full_results=True),
    )

    def ask() -> None:
        try:
            namespaces.invoke("sim.getObjectHandle", [UNKNOWN])
        except UnknownName:
            return
        raise AssertionError("no error")

    ask()
    gc.collect()
    gc.disable()
    try:
        for _ in range(100):
            ask()
        assert gc.collect() < 100
    finally:
        gc.enable()
