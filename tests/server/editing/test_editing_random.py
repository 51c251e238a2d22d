"""Random edits of a scene, stopped and running: what succeeds leaves a tree, and a stop brings the first one back."""

from __future__ import annotations

import contextlib
import math
import random
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from handler_calls import World
from seeds import seeds

from simx_server.editing.compounds import grouping, relocating, ungrouping
from simx_server.errors import CommandError
from simx_server.handlers.quantities.engine import ENGINE
from simx_server.scene.editing.model_state import editable_arrays, get_state
from simx_server.scene.geometry.inertia import set_inertia
from simx_server.scene.objects import ObjectKind
from simx_server.scripting.script import Script, ScriptKind
from simx_server.sim_api.namespaces import Namespaces
from simx_server.simulation.simulation import Simulation

pytestmark = pytest.mark.slow

SCENE = Path(__file__).parents[2] / "conformance" / "scene.xml"
EDITS = 80
MOST_OBJECTS = 60


def random_edit(world: World, choose: random.Random) -> None:
    """One edit with handles of the scene; most are possible."""
    handles = list(world.sim.scene.objects) or [1]
    one, other, third = (choose.choice([*handles, -1]) for _ in range(3))
    if choose.random() < 0.15:
        group_or_cut(world, choose, [one, other, third])
        return
    name = choose.choice(
        ["simxSetObjectParent"] * 6 + ["simxRemoveObject", "simxRemoveModel", "simxCreateDummy"]
    )
    if len(handles) < MOST_OBJECTS and choose.random() < 0.15:
        name = choose.choice(["simxCopyPasteObjects", "simxLoadModel"])
    world.call(
        name,
        *{
            "simxSetObjectParent": [one, other, choose.random() < 0.5],
            "simxRemoveObject": [one],
            "simxRemoveModel": [one],
            "simxCreateDummy": [0.01, None],
            "simxCopyPasteObjects": [[one, other, third]],
            "simxLoadModel": [str(SCENE), 0],
        }[name],
    )


def group_or_cut(world: World, choose: random.Random, handles: list[int]) -> None:
    shapes = list(world.sim.scene.of_kind(ObjectKind.SHAPE))
    if choose.random() < 0.5:
        grouping.group(
            world.parts, handles if choose.random() < 0.3 else choose.sample(shapes, min(2, len(shapes)))
        )
    elif choose.random() < 0.4:
        place = choose.uniform(-1, 1), choose.uniform(-1, 1), choose.uniform(-1, 1)
        relocating.relocate(world.parts, choose.choice(shapes), (place, (0.6, 0.0, 0.8, 0.0)))
    elif choose.random() < 0.7:
        ungrouping.ungroup(world.parts, choose.choice(shapes))
    else:
        ungrouping.divide(world.parts, choose.choice(shapes))


def tree(world: World) -> dict[int, tuple[str, int]]:
    return {handle: (item.name, item.parent) for handle, item in world.sim.scene.objects.items()}


def check_tree(world: World) -> None:
    """Every object has a way up to the top; no name stands twice."""
    objects = world.sim.scene.objects
    for handle in objects:
        way: list[int] = []
        while handle != -1:
            assert handle not in way, f"{[objects[each].name for each in way]} are each other's ancestors"
            way.append(handle)
            handle = objects[handle].parent
    names = [item.name for item in objects.values()]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("seed", seeds(1))
def test_random_edits_leave_a_tree_and_stop_restores_it(seed: int) -> None:
    choose, world, edited = random.Random(seed), World(file=SCENE), 0
    before: dict[int, tuple[str, int]] | None = None
    for number in range(EDITS):
        if number % 20 == 10:
            before = tree(world)
            world.run()
        elif number % 20 == 0 and before is not None:
            world.call("simxStopSimulation")
            assert tree(world) == before
            assert np.isfinite(world.sim.data.qpos).all()
        try:
            random_edit(world, choose)
            edited += 1
        except CommandError:
            continue
        check_tree(world)
    assert edited > EDITS / 4


def test_a_force_sensor_moved_into_a_link_is_its_child() -> None:
    world = World(file=SCENE)
    scale, upper, weight = (world.handle(name) for name in ("scale", "upper", "weight"))
    world.call("simxSetObjectParent", weight, -1, True)
    world.call("simxSetObjectParent", scale, upper, True)
    parent = world.sim.scene.get(upper).parent
    assert world.sim.scene.get(scale).parent == upper
    assert parent == world.handle("shoulder")


def test_a_link_cannot_move_to_what_its_own_joint_carries() -> None:
    world = World(file=SCENE)
    elbow, lower, cube = (world.handle(name) for name in ("elbow", "lower", "cube"))
    world.call("simxSetObjectParent", cube, elbow, True)
    with pytest.raises(CommandError, match="'lower' moves with its joint 'elbow', which carries 'cube'"):
        world.call("simxSetObjectParent", lower, cube, True)


# --- extreme numbers ------------------------------------------------------------------------------

EXTREMES = (0.0, -1.0, 1e300, math.nan, 1e-300, math.inf, 1e10, 1e-9, 1e-5, 0.5, 2.0)
CHANGES = 200


def extreme_change(sim: Simulation, choose: random.Random) -> tuple[str, list[Any]]:
    """A function of scripts, and arguments that change weights, forces, friction, limits or places at random."""
    handles = list(sim.scene.objects)
    shapes = [h for h in handles if sim.scene.objects[h].kind is ObjectKind.SHAPE]
    joints = [h for h in handles if sim.scene.objects[h].kind is ObjectKind.JOINT]
    shape, joint, other = choose.choice(shapes), choose.choice(joints), choose.choice([*joints, -1])

    def number() -> float:
        return choose.choice(EXTREMES)

    def numbers(count: int) -> list[float]:
        return [number() for _ in range(count)]

    inertia = [number() if choose.random() < 0.3 else value for value in (0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1)]
    place = [1.0, 0.0, 0.0, number(), 0.0, 1.0, 0.0, number(), 0.0, 0.0, 1.0, number()]
    return choose.choice(
        [
            ("setShapeMass", [shape, number()]),
            ("setShapeMassAndInertia", [shape, number(), inertia, numbers(3), place]),
            ("setShapeInertia", [shape, inertia, place]),
            ("computeMassAndInertia", [shape, number()]),
            ("setEngineFloatParam", [choose.choice(list(ENGINE)), shape, number()]),
            (
                "setObjectFloatParam",
                [choose.choice(handles), choose.choice((2002, 2017, 2018, 3005)), number()],
            ),
            ("setObjectInt32Param", [shape, choose.choice((3003, 3004)), choose.choice((0, 1))]),
            ("setJointTargetForce", [joint, number()]),
            ("setJointTargetVelocity", [joint, number()]),
            ("setJointTargetPosition", [joint, number()]),
            ("setJointPosition", [joint, number()]),
            ("setJointInterval", [joint, choose.random() < 0.5, numbers(2)]),
            ("setJointDependency", [joint, other, number(), number()]),
            ("setJointMode", [joint, choose.choice((0, 3, 5)), 0]),
            ("addForceAndTorque", [shape, numbers(3), numbers(3)]),
            ("setObjectPosition", [shape, numbers(3), -1]),
            ("setObjectPosition", [joint, [choose.uniform(-1, 1) for _ in range(3)], -1]),
            ("setObjectParent", [shape, other, True]),
            ("scaleObjects", [[shape], number(), True]),
            ("setArrayParam", [0, numbers(3)]),
            ("setFloatParam", [1, number()]),
        ]
    )


@pytest.mark.parametrize("seed", seeds(1))
def test_extreme_numbers_end_in_a_result_or_a_text_and_the_simulation_still_steps(
    seed: int, caplog: pytest.LogCaptureFixture
) -> None:
    choose, world = random.Random(seed), World(file=SCENE)
    sim, done = world.sim, 0
    for number in range(CHANGES):
        if not sim.is_running or number % 20 == 0:
            sim.stop()
            sim.start()
        name, values = extreme_change(sim, choose)
        script = Script(1, ScriptKind.CHILD, next(iter(sim.scene.objects)), "random.lua")
        with contextlib.suppress(CommandError):
            Namespaces(world.parts, script).invoke(f"sim.{name}", values)
            done += 1
        world.parts.step()  # it may diverge, and the run ends then
    sim.stop()
    sim.start()
    for _ in range(3):
        world.parts.step()
    assert sim.is_running
    assert np.isfinite(sim.data.qpos).all()
    assert done > CHANGES / 4
    assert "Traceback" not in caplog.text


def test_a_change_that_mujoco_refuses_is_undone(monkeypatch: pytest.MonkeyPatch) -> None:
    world = World(file=SCENE)
    world.run(2)
    model = world.sim.model
    cube = world.handle("cube")
    arrays = {name: value.copy() for name, value in editable_arrays(model)}
    state = get_state(model, world.sim.data)

    def refuses(*_: object) -> None:
        model.body_subtreemass[:] = -1.0  # it stops half way
        raise mujoco.FatalError("mj_setConstGroups: body 1 is compiled as simple,\nuse body/simple='false'")

    with monkeypatch.context() as broken:
        broken.setattr(mujoco, "mj_setConst", refuses)
        with pytest.raises(CommandError, match="mj_setConstGroups: body 1 is compiled as simple, use"):
            world.call("simxSetObjectFloatParameter", cube, 3005, 3.0)
        with pytest.raises(CommandError, match="mj_setConstGroups"):
            set_inertia(world.sim, cube, 2.0, np.eye(3), np.zeros(3))
    assert world.sim.model is model
    for name, value in editable_arrays(model):
        assert np.array_equal(value, arrays[name], equal_nan=value.dtype.kind == "f"), name
    assert np.array_equal(get_state(model, world.sim.data), state)
    world.call("simxSetObjectFloatParameter", cube, 3005, 3.0)
    assert world.call("simxGetObjectFloatParameter", cube, 3005) == pytest.approx(3.0)
    world.parts.step()
    assert world.sim.is_running
