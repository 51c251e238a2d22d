"""Places of positions and targets that were found before give the same as places found at each call."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest
from random_joints import mechanism
from scenes_for_tests import world_of
from seeds import seeds

from simx_server.errors import CommandError
from simx_server.joints import JointMode, Joints
from simx_server.scene.editing import editing

Edit = Callable[[Joints, int, random.Random], Any]

EDITS: dict[str, Edit] = {
    "position": lambda joints, handle, _: joints.position(handle),
    "target": lambda joints, handle, chance: joints.set_target_position(handle, chance.uniform(-4, 4)),
    "no target": lambda joints, handle, _: joints.set_target_position(handle, float("nan")),
    "place": lambda joints, handle, chance: joints.set_position(handle, chance.uniform(-9, 9)),
    "velocity": lambda joints, handle, chance: joints.set_target_velocity(handle, chance.choice((0, 1.5))),
    "mode": lambda joints, handle, chance: joints.set_mode(handle, chance.choice(list(JointMode))),
    "interval": lambda joints, handle, chance: joints.set_interval(handle, chance.random() < 0.5, -8, 16),
    "motor": lambda joints, handle, chance: joints.change(handle, motor=chance.random() < 0.7),
    "loop": lambda joints, handle, chance: joints.change(handle, control_loop=chance.random() < 0.7),
    "spring": lambda joints, handle, chance: joints.change(handle, spring=chance.random() < 0.3),
    "profile": lambda joints, handle, chance: joints.limit_motion(handle, [1.0, chance.choice((0.0, 2.0))]),
    "fix": lambda joints, handle, chance: joints.fix(handle, chance.random() < 0.3),
    "inert": lambda joints, handle, chance: joints.hold_inert([handle] if chance.random() < 0.3 else []),
    "unknown": lambda joints, handle, _: joints.position(handle + 1000),
}
USUAL = ("position", "target")


def told(scene: str, seed: int, *, is_forgetful: bool) -> list[Any]:
    """Return the results of random calls, and the positions after each simulation step.

    Args:
        is_forgetful: no place that was found is used a second time.
    """
    world, chance, found = world_of(scene), random.Random(seed), list[Any]()
    simulation = world.simulation
    handles = list(simulation.joints.remember().states)
    simulation.start()
    for number in range(40):
        for handle in handles:
            for name in (*USUAL, chance.choice(list(EDITS)), *USUAL):
                joints = simulation.joints
                if is_forgetful:
                    joints.forget_places()
                try:
                    found.append((name, EDITS[name](joints, handle, chance)))
                except CommandError as refusal:
                    found.append((name, str(refusal)))
        world.step()
        found.append(simulation.data.qpos.tobytes())
        if number == 20:
            simulation.stop()
            editing.remove_object(simulation, handles[-1])
            simulation.start()
        handles = [handle for handle in handles if handle in simulation.scene.objects]
    return found


@pytest.mark.parametrize("seed", seeds(6))
def test_known_places_give_the_same_as_places_found_at_each_call(seed: int) -> None:
    scene = mechanism(seed)
    assert told(scene, seed, is_forgetful=False) == told(scene, seed, is_forgetful=True)
