"""Shapes in the same place are counted before physics meets them: within one physics step no client can be served."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from handler_calls import World
from observing import observe

from simx_server.joints.guards import crowding
from simx_server.joints.guards.crowding import FEW, is_crowded
from simx_server.limits import Limits
from simx_server.simulation.simulation import SimulationState


def scattered(count: int, fixed: int, size: float) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Turned boxes at random places of a cube; the first ones are fixed."""
    chance, spec = np.random.default_rng(count + fixed), mujoco.MjSpec()
    for number in range(count):
        body = spec.worldbody.add_body(pos=chance.uniform(0, size, 3), quat=chance.normal(size=4))
        if number >= fixed:
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=(0.05, 0.03, 0.02), pos=(0.01, 0, 0))
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=(1, 1, 1))
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def counted(model: mujoco.MjModel, data: mujoco.MjData) -> int:
    """One by one: pairs of boxes around shapes that overlap, planes left out."""
    boxes, moves = [], []
    for geom in range(model.ngeom):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_PLANE:
            turn = data.geom_xmat[geom].reshape(3, 3)
            centre = data.geom_xpos[geom] + turn @ model.geom_aabb[geom, :3]
            boxes.append((centre, np.abs(turn) @ model.geom_aabb[geom, 3:]))
            moves.append(bool(model.body_weldid[model.geom_bodyid[geom]]))
    return sum(
        (moves[one] or moves[other])
        and bool((np.abs(boxes[one][0] - boxes[other][0]) <= boxes[one][1] + boxes[other][1]).all())
        for one in range(len(boxes))
        for other in range(one)
    )


@pytest.mark.parametrize(
    ("count", "fixed", "size"),
    [(FEW + 20, 0, 0.3), (FEW + 20, 200, 0.3), (FEW + 20, FEW, 0.2), (FEW + 20, 0, 0.01)],
)
def test_pairs_are_counted_exactly(
    monkeypatch: pytest.MonkeyPatch, count: int, fixed: int, size: float
) -> None:
    monkeypatch.setattr(crowding, "_AT_ONCE", 1000)
    model, data = scattered(count, fixed, size)
    pairs = counted(model, data)
    assert pairs > 100
    assert not is_crowded(model, data, pairs)
    assert is_crowded(model, data, pairs - 1)
    assert is_crowded(model, data, pairs // 2)


def test_few_shapes_are_not_counted() -> None:
    assert not is_crowded(*scattered(FEW, 0, 0.01), most=1)


def heap() -> World:
    balls = "".join(
        f'<body name="b{n}" pos="{n % 10} {n // 10} 1"><joint type="slide"/><geom size="0.1"/></body>'
        for n in range(FEW + 1)
    )
    world = World(f'<mujoco><option gravity="0 0 0"/><worldbody>{balls}</worldbody></mujoco>')
    world.sim.limits = Limits(near_pairs=20)
    return world


def test_a_run_in_which_too_many_shapes_are_put_in_one_place_is_stopped_and_told() -> None:
    world, told = heap(), []
    observe(world.sim, script_stopped=told.append)
    world.sim.start()
    world.parts.step()
    assert world.sim.state is SimulationState.RUNNING
    for number in range(8):  # 28 pairs
        world.call("simxSetObjectPosition", world.handle(f"b{number}"), -1, [0.0, 0.0, 0.0])
    world.parts.step()
    assert world.sim.state is SimulationState.STOPPED
    assert told[0].startswith(
        "too many shapes are in the same place at 0.050 s; the simulation is stopped; at most 20"
    )
    assert "--limit near_pairs=N" in told[0]
    world.sim.start()  # a stop has brought them back
    world.parts.step()
    assert world.sim.state is SimulationState.RUNNING


def test_motors_without_room_for_their_constraints_stop_the_run_with_what_to_do() -> None:
    boxes = "".join(
        f'<body pos="{0.1 * (i % 6)} {0.1 * (i // 6)} 0.05"><freejoint/><geom type="box" size=".05 .05 .05"/></body>'
        for i in range(36)
    )
    world = World(
        '<mujoco><size memory="200K"/><worldbody><geom type="plane" size="5 5 .1"/>'
        f'<body pos="0 0 2"><joint name="hinge" axis="0 1 0"/><geom size=".1"/></body>{boxes}</worldbody>'
        '<actuator><velocity joint="hinge"/></actuator><custom><text name="simx:joint:hinge" data="max_force=10"/>'
        "</custom></mujoco>"
    )
    told: list[str] = []
    observe(world.sim, script_stopped=told.append)
    world.sim.start()
    world.parts.step()
    assert world.sim.state is SimulationState.STOPPED
    assert "a larger <size memory=...>" in told[0]
