"""The worlds made of V-REP's own files run: nothing diverges, and what rests stays at rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from vrep_samples import decoded, each_kind_of_sample, world_of

from simx_server.scene.formats.vrep.objects import Joint, Shape

STEPS = 10


@each_kind_of_sample
def test_half_a_second_passes_without_a_jump(path: Path) -> None:
    file, world = decoded(path), world_of(path)
    sim = world.sim
    before = sim.data.xpos.copy()
    driven = any(isinstance(o, Joint) and o.motor and o.target_velocity for o in file.objects.values())
    sim.start()
    for _ in range(STEPS):
        world.parts.step()
        assert sim.is_running
    moved = np.abs(sim.data.xpos - before).max() if sim.data.xpos.shape == before.shape else 0.0
    on_a_floor = not file.is_model and any(isinstance(o, Shape) for o in file.objects.values())
    assert np.isfinite(sim.data.qpos).all()
    assert not on_a_floor or moved < (10.0 if driven else 3.0)
    sim.stop()
    assert not sim.is_running
