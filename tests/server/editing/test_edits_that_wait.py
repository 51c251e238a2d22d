"""Edits wait for the compile until something reads the model: a burst costs one, with the same results."""

from __future__ import annotations

import random
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from handler_calls import World
from seeds import seeds

from simx_server.editing import copying, creating, creating_parts, models, object_flags
from simx_server.errors import CommandError
from simx_server.handlers.objects import objects, poses
from simx_server.scene.editing import recompile
from simx_server.scene.editing.model_state import editable_arrays, get_state
from simx_server.scene.object_listing import list_objects
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses import frames
from simx_server.scene.tree import Builder

SCENE = """
<mujoco>
  <option timestep="0.01"/>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1"/>
    <body name="table" pos="1 0 0.2">
      <geom name="top" type="box" size="0.3 0.3 0.02"/><site name="mark" pos="0 0 0.1"/>
    </body>
    <body name="arm" pos="-1 0 0.5">
      <geom size="0.1"/>
      <body name="link" pos="0 0 0.2"><joint name="hinge" axis="0 1 0"/><geom size="0.05" pos="0.2 0 0"/></body>
    </body>
    <body name="ball" pos="0 0.5 0.3"><freejoint/><geom size="0.1"/></body>
    {blocks}
    <body name="gripper" pos="0 -1 0.5"><geom size="0.05"/><site name="grip"/></body>
    <camera name="eye" pos="0 0 3"/>
  </worldbody>
  <sensor><force site="grip"/><torque site="grip"/><framepos objtype="body" objname="block1"/></sensor>
</mujoco>
"""

SCENE = SCENE.replace(
    "{blocks}",
    "".join(
        f'<body name="block{i}" pos="{i % 4} 2 0.1">{"<freejoint/>" if i % 2 else ""}<geom size="0.05"/></body>'
        for i in range(8)
    ),
)

MASKED = SCENE.replace(
    "</mujoco>",
    "<custom>"
    + "".join(
        f'<text name="simx:shape:{name}" data="mask={mask}"/>'
        for name, mask in (
            *((f"block{i}", ("0x0f0f", "0xffff", "0xf0f0", "0xff00")[i % 4]) for i in range(8)),
            *(("table", "0xffff"), ("ball", "0x00ff")),
        )
    )
    + "</custom></mujoco>",
)
"""The same with respondable masks of the file, as every V-REP scene has them."""

KINDS = ("cuboid", "spheroid", "cylinder", "cone", "capsule", "plane", "disc")


@pytest.fixture
def compiles(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows by one with each compile of the scene."""
    made: list[int] = []
    real = recompile.compile_spec

    def counted(*arguments: Any) -> Any:
        made.append(1)
        return real(*arguments)

    monkeypatch.setattr(recompile, "compile_spec", counted)
    return made


def create(world: World, kind: str = "cuboid", *, static: bool = True, size: float = 0.1) -> int:
    body = creating.Body(static=static, respondable=True, lacks=("detectable",) if size > 0.1 else ())
    return creating.create_primitive(world.parts, kind, [size, size * 1.5, size * 2], body)


def test_fifty_new_shapes_are_one_compile(compiles: list[int]) -> None:
    world = World(SCENE)
    handles = [create(world) for _ in range(50)]
    world.parts.idle()
    assert not compiles
    assert handles == list(range(handles[0], handles[0] + 50))
    names = [world.sim.scene.get(handle).name for handle in handles]
    assert names[:3] == ["Cuboid", "Cuboid0", "Cuboid1"]
    assert world.handle("Cuboid48") == handles[-1]
    assert world.sim.scene.of_kind(ObjectKind.SHAPE)[-50:] == handles
    assert not compiles
    assert world.sim.model.nbody == 14 + 50
    assert len(compiles) == 1


def test_shapes_are_placed_coloured_and_shown_before_the_compile(compiles: list[int]) -> None:
    world = World(SCENE)
    handles: list[int] = []
    for number in range(50):
        handles.append(create(world, static=bool(number % 2)))
        poses.reset_dynamic_object(world.parts, handles[-1])
        world.call("simxSetObjectPosition", handles[-1], -1, [0.1 * number, 1, 2])
        world.call("simxSetObjectOrientation", handles[-1], handles[0], [0, 0, 0.1])
        assert world.parts.shape_colors.set(handles[-1], 0, [1, 0, 0.5]) == 1
        flags = object_flags.special_flags(world.parts, handles[-1])
        object_flags.set_special_flags(world.parts, handles[-1], flags)
    assert not compiles
    for number, handle in enumerate(handles):
        assert frames.get_position(world.sim, handle) == pytest.approx([0.1 * number, 1, 2])
        assert world.parts.shape_colors.get(handle, 0) == [1, 0, 0.5]
    assert len(compiles) == 1


@pytest.mark.parametrize("scene", [SCENE, MASKED], ids=["plain", "masked"])
def test_fifty_removals_are_one_compile(scene: str, compiles: list[int]) -> None:
    world = World(scene)
    handles = [create(world, static=bool(number % 2)) for number in range(50)]
    ball = frames.get_position(world.sim, world.handle("ball"))
    last = create(world)
    world.sim.compile_edits()
    del compiles[:]
    for handle in (world.handle("block0"), world.handle("block3"), *handles):
        world.call("simxRemoveObject", handle)
        with pytest.raises(CommandError):
            world.call("simxGetObjectPosition", handle, -1)
    assert not compiles
    assert frames.get_position(world.sim, world.handle("ball")) == ball
    assert frames.get_position(world.sim, last) == [0, 0, 0]
    assert len(compiles) == 1
    assert world.sim.model.nbody == 14 + 1 - 2


UNLIKE_SHAPES = ("table", "link", "arm", "gripper", "block1", "eye", "hinge", "floor")
"""Objects with something on them, of a mechanism, or that a sensor refers to."""


@pytest.mark.parametrize("name", UNLIKE_SHAPES)
def test_an_object_that_others_have_to_do_with_is_removed_at_once(name: str, compiles: list[int]) -> None:
    world = World(SCENE)
    world.call("simxRemoveObject", world.handle(name))
    assert len(compiles) == 1
    assert world.sim.waiting is None


def test_created_and_removed_shapes_wait_together(compiles: list[int]) -> None:
    world = World(SCENE)
    world.run()
    for number in range(8):
        block = world.handle(f"block{number}")
        if number != 1:
            world.call("simxRemoveObject", block)
        world.call("simxSetObjectPosition", create(world), -1, [number, 0, 1])
    assert not compiles
    assert frames.get_position(world.sim, world.handle("Cuboid6")) == [7, 0, 1]
    assert len(compiles) == 1
    world.call("simxStopSimulation")
    assert world.handle("block7")


LAMP = """
<mujoco>
  <worldbody>
    <body name="lamp"><geom size="0.1"/>
      <body name="head" pos="0 0 1"><joint name="neck" range="-1 1"/><geom size="0.1"/><site name="bulb"/></body>
    </body>
  </worldbody>
  <sensor><force site="bulb"/><torque site="bulb"/></sensor>
</mujoco>
"""


def tetrahedron(size: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    points = np.array([[0, 0, 0], [size, 0, 0], [0, size, 0], [0, 0, size]])
    return points, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


ADDITIONS: dict[str, tuple[Callable[[World], object], int]] = {
    "copies of a static shape": (
        lambda world: world.call("simxCopyPasteObjects", [world.handle("block0")]),
        1,
    ),
    "copies of a free shape": (lambda world: world.call("simxCopyPasteObjects", [world.handle("ball")]), 1),
    "copies of a tree": (
        lambda world: world.call(
            "simxCopyPasteObjects", [world.handle(name) for name in ("arm", "link", "hinge")]
        ),
        3,
    ),
    "copies of a part": (
        lambda world: world.call("simxCopyPasteObjects", [world.handle("hinge"), world.handle("link")]),
        2,
    ),
    "models": (lambda world: world.call("simxLoadModel", "lamp.xml", 0), 4),
    "joints": (lambda world: creating_parts.create_joint(world.parts, 10, 5, hybrid=False), 1),
    "force sensors": (
        lambda world: creating_parts.create_force_sensor(world.parts, 0, [0, 1, 1], [0.01, 0, 0]),
        1,
    ),
    "meshes": (lambda world: creating.create_mesh(world.parts, *tetrahedron(), "Mesh", creating.Body()), 1),
    "cones": (lambda world: create(world, "cone"), 1),
}
"""What adds objects, and how many."""


@pytest.mark.parametrize(("add", "count"), ADDITIONS.values(), ids=ADDITIONS)
def test_twenty_additions_are_one_compile(
    add: Callable[[World], object], count: int, compiles: list[int], tmp_path: Path
) -> None:
    (tmp_path / "lamp.xml").write_text(LAMP, encoding="utf-8")
    world = World(SCENE, workspace=tmp_path)
    before, first = len(world.sim.scene.objects), world.sim.scene.next_handle
    for _ in range(20):
        add(world)
    assert not compiles
    objects = world.sim.scene.objects
    assert len(objects) == before + 20 * count
    assert list(objects)[before:] == list(range(first, first + 20 * count))
    assert len({item.name for item in objects.values()}) == len(objects)
    assert world.sim.model.nbody > 14 + 19
    assert len(compiles) == 1
    check_numbers(world)


def test_copies_have_the_state_that_their_originals_had(compiles: list[int]) -> None:
    world = World(SCENE)
    link, hinge, ball = (world.handle(name) for name in ("link", "hinge", "ball"))
    world.run()
    world.call("simxSetJointPosition", hinge, 0.3)
    world.call("simxSetJointTargetVelocity", hinge, 0.5)
    del compiles[:]
    copy, _, _ = world.call("simxCopyPasteObjects", [hinge, link, ball])
    other = world.call("simxCopyPasteObjects", [hinge, link])[0]
    assert not compiles
    world.call("simxSetJointPosition", hinge, -0.2)
    assert [world.call("simxGetJointPosition", each) for each in (copy, other, hinge)] == [0.3, 0.3, -0.2]
    assert world.sim.joints.target_velocity(copy) == 0.5
    assert len(compiles) == 1


def test_a_joint_that_waits_is_compiled_when_it_is_used(compiles: list[int]) -> None:
    world = World(SCENE)
    joint = creating_parts.create_joint(world.parts, 11, 0, hybrid=False)
    assert not compiles
    world.call("simxSetJointPosition", joint, 0.1)
    assert len(compiles) == 1
    assert world.call("simxGetJointPosition", joint) == 0.1


LATER_JOINTS = """
<mujoco>
  <worldbody>
    <body name="box" pos="1 0 1"><freejoint/><geom size="0.1"/></body>
    <body name="pole" pos="0 0 1">
      <joint name="hinge" axis="0 1 0" range="-1 1" limited="true"/><geom size="0.1" pos="0.3 0 0"/>
      <body pos="0.3 0 0"><joint name="wheel" axis="0 1 0"/><geom size="0.05" pos="0.1 0 0"/></body>
    </body>
    <body name="ball" pos="2 0 1"><freejoint/><geom size="0.1"/></body>
  </worldbody>
  <actuator><position name="hinge" joint="hinge" kp="100"/></actuator>
</mujoco>
"""

OF_JOINTS: dict[str, Callable[[World, int], object]] = {
    "its position": lambda world, hinge: world.call("simxGetJointPosition", hinge),
    "its matrix": lambda world, hinge: world.call("simxGetJointMatrix", hinge),
    "its limits": lambda world, hinge: world.sim.joints.interval(hinge),
    "a new position": lambda world, hinge: world.call("simxSetJointPosition", hinge, 0.4),
    "new limits": lambda world, hinge: world.sim.joints.set_interval(hinge, False, -0.5, 1.5),
    "another mode": lambda world, hinge: world.sim.joints.change(hinge, motor=False),
    "a target": lambda world, hinge: world.call("simxSetJointTargetPosition", hinge, 0.5),
}


@pytest.mark.parametrize("use", OF_JOINTS.values(), ids=OF_JOINTS)
def test_joints_behind_a_removed_shape_are_where_the_model_has_them(
    use: Callable[[World, int], object],
) -> None:
    seen: list[Any] = []
    for compile_first in (True, False):
        world = World(LATER_JOINTS)
        hinge, wheel = world.handle("hinge"), world.handle("wheel")
        world.call("simxSetJointPosition", hinge, 0.2)
        world.call("simxSetJointPosition", wheel, -0.3)
        world.call("simxRemoveObject", world.handle("box"))
        assert world.sim.waiting is not None
        if compile_first:
            world.sim.compile_edits()
        used = use(world, hinge)
        assert world.sim.waiting is None
        positions = [world.call("simxGetJointPosition", each) for each in (hinge, wheel)]
        state = get_state(world.sim.model, world.sim.data).tolist()
        seen.append([used, positions, world.sim.joints.interval(hinge), state])
    assert seen[0] == seen[1]


def test_velocities_behind_a_removed_shape_are_those_of_the_same_objects() -> None:
    seen: list[Any] = []
    for compile_first in (True, False):
        world = World(LATER_JOINTS)
        ball, pole = world.handle("ball"), world.handle("pole")
        world.run(3)
        world.call("simxRemoveObject", world.handle("box"))
        assert world.sim.waiting is not None
        if compile_first:
            world.sim.compile_edits()
        seen.append([world.call("simxGetObjectVelocity", each) for each in (ball, pole)])
    assert seen[0] == seen[1]
    assert seen[0][0] != seen[0][1]


def test_models_are_placed_before_the_compile(compiles: list[int], tmp_path: Path) -> None:
    (tmp_path / "lamp.xml").write_text(LAMP, encoding="utf-8")
    world = World(SCENE, workspace=tmp_path)
    lamps = [world.call("simxLoadModel", "lamp.xml", 0) for _ in range(3)]
    copies = world.call("simxCopyPasteObjects", [world.handle("table"), world.handle("ball")])
    for number, handle in enumerate((*lamps, *copies)):
        world.call("simxSetObjectPosition", handle, -1, [number, 1, 2])
    assert not compiles
    for number, handle in enumerate((*lamps, *copies)):
        assert frames.get_position(world.sim, handle) == pytest.approx([number, 1, 2])
    head = world.handle("head#1")
    assert frames.get_position(world.sim, head) == pytest.approx([2, 1, 3])
    assert len(compiles) == 1


NOT_LATE: dict[str, Callable[[World], object]] = {
    "a link without its joint": lambda world: world.call("simxCopyPasteObjects", [world.handle("link")]),
    "a joint without its link": lambda world: world.call("simxCopyPasteObjects", [world.handle("hinge")]),
    "a camera of the world": lambda world: world.call("simxCopyPasteObjects", [world.handle("eye")]),
    "a part of the world": lambda world: world.call("simxCopyPasteObjects", [world.handle("floor")]),
    "a copy that waits": lambda world: world.call(
        "simxCopyPasteObjects",
        world.call("simxCopyPasteObjects", [world.handle("link"), world.handle("hinge")])[:1],
    ),
}


@pytest.mark.parametrize("copy", NOT_LATE.values(), ids=NOT_LATE)
def test_other_copies_are_compiled_at_once(copy: Callable[[World], object], compiles: list[int]) -> None:
    world = World(SCENE)
    copy(world)
    assert compiles
    assert world.sim.waiting is None
    check_numbers(world)


def check_numbers(world: World) -> None:
    """The scene's numbers are those that its whole model gives them."""
    sim = world.sim
    builder = Builder(sim.model, sim.scene.annotations, sim.scene.hidden_bodies, None, sim.scene.unseen_sites)
    builder.build()
    made, known = (
        {(each.element, each.element_name, each.id, each.body, each.sensors) for each in many.values()}
        for many in (builder.objects, sim.scene.objects)
    )
    assert made == known


READS: dict[str, Callable[[World, int], object]] = {
    "a position": lambda world, shape: frames.get_position(world.sim, shape),
    "a position of another object": lambda world, shape: world.call(
        "simxGetObjectPosition", world.handle("ball"), -1
    ),
    "a step": lambda world, shape: world.parts.step(),
    "a parent": lambda world, shape: world.call("simxSetObjectParent", shape, world.handle("table"), True),
    "a stop": lambda world, shape: world.call("simxStopSimulation"),
}


@pytest.mark.parametrize("read", READS.values(), ids=READS)
def test_what_reads_the_model_has_it_compiled(read: Callable[[World, int], object]) -> None:
    world = World(SCENE)
    world.run(2)
    shape = create(world)
    waiting = world.sim.waiting
    assert waiting is not None
    assert shape in waiting.handles
    read(world, shape)
    assert world.sim.waiting is None


def test_a_scene_that_was_edited_without_a_compile_is_compiled_at_once(compiles: list[int]) -> None:
    """Its elements get other ids with the next compile."""
    world = World(SCENE)
    world.call("simxCreateDummy", 0.01, None)
    world.call("simxRemoveObject", world.call("simxCreateDummy", 0.01, None))
    del compiles[:]
    create(world)
    assert len(compiles) == 1
    create(world)
    assert len(compiles) == 1


def test_an_error_comes_with_the_edit_that_causes_it(compiles: list[int]) -> None:
    world = World(SCENE)
    create(world)
    points, faces = np.zeros((4, 3)), np.array([[0, 1, 2]])
    with pytest.raises(CommandError, match="cannot be changed that way"):
        creating.create_mesh(world.parts, points, faces, "Mesh", creating.Body())
    shape = create(world)
    with pytest.raises(CommandError, match="3 finite numbers"):
        frames.set_position(world.sim, shape, -1, [0, 0, float("nan")])
    with pytest.raises(CommandError, match="999"):
        world.call("simxSetObjectPosition", shape, 999, [0, 0, 0])
    with pytest.raises(CommandError, match="colour"):
        world.parts.shape_colors.set(shape, 0, [1])
    object.__setattr__(world.sim.limits, "objects", len(world.sim.scene.objects))
    with pytest.raises(CommandError, match="objects"):
        create(world)
    assert world.sim.waiting is not None
    assert world.sim.scene.get(shape).name == "Cuboid0"
    assert frames.get_position(world.sim, shape) == [0, 0, 0]


def test_a_scene_that_cannot_be_compiled_loses_what_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """No program is known that reaches this: MuJoCo has compiled each shape alone before."""
    world = World(SCENE)
    world.run()
    before, real = list_objects(world.sim), recompile.compile_spec

    def refusing(*_arguments: Any) -> Any:
        raise ValueError("no memory")

    monkeypatch.setattr(recompile, "compile_spec", refusing)
    shape = create(world)
    with pytest.raises(CommandError, match="no memory"):
        world.call("simxGetObjectPosition", shape, -1)
    assert list_objects(world.sim) == before
    other = create(world)
    assert other == shape + 1
    world.call("simxStopSimulation")
    assert not world.sim.is_running
    monkeypatch.setattr(recompile, "compile_spec", real)
    last = create(world)
    assert last == other + 1
    assert frames.get_position(world.sim, last) == [0, 0, 0]


def test_the_stop_removes_shapes_that_still_wait() -> None:
    world = World(SCENE)
    before = list_objects(world.sim)
    world.run()
    shape = create(world)
    world.call("simxStopSimulation")
    assert list_objects(world.sim) == before
    assert create(world) == shape + 1


def test_shapes_that_wait_are_gone_with_their_scene() -> None:
    world = World(SCENE)
    create(world)
    world.sim.close()
    assert world.sim.waiting is None
    assert "Cuboid" not in world.sim.scene.by_names()


# --- random programs, with a compile for each shape and without ----------------------------------------


def random_call(world: World, choose: random.Random, made: list[int]) -> Callable[[], object]:
    """Return the next call of a program; shapes that it made are concerned most of all."""
    handles = list(world.sim.scene.objects)
    one = choose.choice(made) if made and choose.random() < 0.8 else choose.choice(handles)
    other, kind = choose.choice([*handles, -1, -1, -11]), choose.choice(KINDS)
    place = [choose.uniform(-0.3, 0.3) for _ in range(3)]
    color, component = [choose.random() for _ in range(3)], choose.choice((0, 0, 4, 2))
    static, size = choose.random() < 0.6, choose.uniform(0.05, 0.15)
    some, joint = choose.sample(handles, choose.choice((1, 1, 2, 3))), choose.choice((10, 11, 12))
    calls: list[tuple[int, Callable[[], object]]] = [
        (8, lambda: made.append(create(world, kind, static=static, size=size))),
        (8, lambda: world.call("simxSetObjectPosition", one, other, place)),
        (4, lambda: world.call("simxSetObjectOrientation", one, other, place)),
        (2, lambda: poses.reset_dynamic_object(world.parts, one)),
        (4, lambda: world.parts.shape_colors.set(one, component, color)),
        (2, lambda: object_flags.set_special_flags(world.parts, one, int(255 * color[0]))),
        (1, lambda: world.parts.object_settings.set_mask(one, choose.choice((0xFF00, 0x0101, 0)))),
        (3, lambda: world.call("simxRemoveObject", choose.choice(handles))),
        (1, lambda: world.call("simxCreateDummy", 0.01, None)),
        (1, lambda: world.call("simxSetObjectParent", one, other, True)),
        (4, lambda: made.extend(world.call("simxCopyPasteObjects", some))),
        (2, lambda: made.extend(world.call("simxCopyPasteObjects", [one]))),
        (3, lambda: made.append(world.call("simxLoadModel", "lamp.xml", 0))),
        (1, lambda: made.append(creating_parts.create_joint(world.parts, joint, 5, hybrid=False))),
        (
            1,
            lambda: made.append(
                creating.create_mesh(world.parts, *tetrahedron(size), "Mesh", creating.Body())
            ),
        ),
        (1, lambda: world.call("simxSetJointPosition", one, place[0])),
        (1, lambda: world.call("simxSetJointTargetVelocity", one, place[0])),
        (2, world.parts.step),
    ]
    return choose.choices([call for _, call in calls], [weight for weight, _ in calls])[0]


def whole(world: World) -> dict[str, Any]:
    """All that a program could notice: objects, the model's numbers, the state, the velocities of surfaces."""
    sim = world.sim
    arrays = {name: value.tobytes() for name, value in editable_arrays(sim.model)}
    stat = {
        name: np.array(getattr(sim.model.stat, name)).tolist() for name in ("extent", "center", "meanmass")
    }
    speeds = {handle: world.parts.velocities.measure(handle) for handle in sim.scene.objects}
    sim.refresh()
    check_numbers(world)
    return {
        "objects": list_objects(sim),
        "owners": sim.scene.owners.tolist(),
        "names": re.sub(rb"~slot\d+", b"~slot", sim.model.names),  # numbered by compiles
        "arrays": arrays,
        "stat": stat,
        "state": get_state(sim.model, sim.data).tobytes(),
        "places": sim.data.xpos.tobytes(),
        "speeds": speeds,
        "contacts": sim.data.ncon,
    }


def program(seed: int, folder: Path, after: Callable[[World], object]) -> None:
    """Make random calls, started and stopped; `after` each."""
    choose, made = random.Random(seed), list[int]()
    world = World(MASKED if seed % 2 else SCENE, workspace=folder)
    for number in range(120):
        if number % 60 == 20:
            world.run(1)
        elif number % 60 == 59:
            world.call("simxStopSimulation")
        made[:] = [handle for handle in made if handle in world.sim.scene.objects]
        try:
            random_call(world, choose, made)()
        except CommandError:
            continue
        after(world)


def sometimes(seed: int, look: Callable[[World], object]) -> Callable[[World], None]:
    """Return what looks after some calls of a program, at the same moments for one seed."""
    choose = random.Random(seed)

    def after(world: World) -> None:
        if choose.random() < 0.15:
            look(world)

    return after


@pytest.mark.slow
@pytest.mark.parametrize("seed", seeds(2))
def test_a_compile_for_each_edit_gives_the_same(
    seed: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "lamp.xml").write_text(LAMP, encoding="utf-8")
    compiled: list[dict[str, Any]] = []
    with monkeypatch.context() as at_once:
        for module in (creating, copying, models):
            at_once.setattr(module, "may_wait", lambda *_arguments: False)
        at_once.setattr(objects, "remove_shape", lambda *_arguments: False)
        program(seed, tmp_path, sometimes(seed, lambda world: compiled.append(whole(world))))
    expected = iter(compiled)

    def compare(world: World) -> None:
        before, found = next(expected), whole(world)
        assert [key for key in before if before[key] != found[key]] == []

    program(seed, tmp_path, sometimes(seed, compare))
    assert next(expected, None) is None
