"""Particle objects: they fly by gravity and drag, and viewers draw them."""

from __future__ import annotations

import math

import pytest
from sim_api_calls import ScriptWorld, world

__all__ = ["world"]

ADD = "sim.addParticleObject(sim.particle_spheres + %s, 0.005, 1, {2, 1, 5, 0}, 0.5, 50, {0.3, 0.7, 1})"


def test_particles_are_added_and_removed(world: ScriptWorld) -> None:
    world.lua(f"jet = {ADD % 'sim.particle_ignoresgravity'}")
    assert world.value("sim.addParticleObjectItem(jet, {0, 0, 1, 0, 0, 0})") == 1
    assert world.value("sim.addParticleObjectItem(jet, nil)") == 1
    assert world.value("sim.removeParticleObject(jet)") == 1
    world.fails("sim.addParticleObjectItem(jet, {0, 0, 1, 0, 0, 0})", "no particle object with handle")
    assert world.value("sim.removeParticleObject(sim.handle_all)") == 1


def test_a_particle_has_the_numbers_of_its_kind(world: ScriptWorld) -> None:
    world.lua(f"jet = {ADD % 'sim.particle_itemsizes + sim.particle_itemcolors'}")
    world.fails("sim.addParticleObjectItem(jet, {0, 0, 1, 0, 0, 0})", "has 10 numbers, not 6")
    world.fails("sim.addParticleObject(9, 0.1, 1, nil, 1, 1)", "9 is no kind of particles")


def test_the_log_says_once_that_particles_do_not_push(world: ScriptWorld) -> None:
    world.lua(f"{ADD % '0'} {ADD % 'sim.particle_respondable1to4'} {ADD % 'sim.particle_respondable1to4'}")
    assert sum("particles push nothing" in line for line in world.parts.status_bar.messages) == 1


def flown(world: ScriptWorld, handle: int) -> tuple[list[float], list[float]]:
    """Place and velocity of the only particle."""
    particles = world.parts.particles.get(handle)
    return particles.places[0].tolist(), particles.velocities[0].tolist()


def test_gravity_moves_particles_unless_they_ignore_it(world: ScriptWorld) -> None:
    world.sim.model.opt.gravity[:] = [0, 0, -10]
    falling, floating = world.lua(
        f"return {ADD % '0'}, sim.addParticleObject(sim.particle_ignoresgravity, 0.01, 1000, nil, 0, 1)"
    )
    for handle in (falling, floating):
        assert world.value(f"sim.addParticleObjectItem({handle}, {{0, 0, 5, 1, 0, 5}})") == 1
    world.passes(4)
    place, velocity = flown(world, floating)
    assert (place, velocity) == (pytest.approx([0.2, 0, 5]), pytest.approx([1, 0, 0]))
    world.lua(f"sim.addParticleObjectItem({falling}, nil)")
    free = world.value("sim.addParticleObject(0, 0.01, 1000, nil, 0, 1)")
    world.lua(f"sim.addParticleObjectItem({free}, {{0, 0, 5, 1, 0, 5}})")
    assert world.lua(f"return sim.addParticleObjectItem({free}, {{0, 0, 5, 1, 0, 5}})") == [0], "it is full"
    world.passes(4)
    place, velocity = flown(world, free)
    assert velocity == pytest.approx([1, 0, -2])
    assert place == pytest.approx([0.2, 0, 4.8], abs=0.006)


def test_drag_stops_particles_and_their_time_ends(world: ScriptWorld) -> None:
    drag = "{5, 0.1}"
    jet = world.value(f"sim.addParticleObject(sim.particle_ignoresgravity, 0.1, 1000, {drag}, 0.3, 10)")
    world.lua(f"sim.addParticleObjectItem({jet}, {{0, 0, 5, 2, 0, 5}})")
    world.passes(4)
    mass = 1000 * math.pi / 6 * 0.001
    assert flown(world, jet)[1][0] == pytest.approx(2 * math.exp(-0.1 / mass * 0.2), rel=0.01)
    world.passes(2)
    assert len(world.parts.particles.get(jet).ages) == 0


def test_water_carries_its_particles(world: ScriptWorld) -> None:
    world.sim.model.opt.gravity[:] = [0, 0, -10]
    make = "sim.addParticleObject(sim.particle_water + sim.particle_cyclic, 0.1, 1000, {7, 50, 8, 1}, 0, 1)"
    water = world.value(make)
    world.lua(f"sim.addParticleObjectItem({water}, {{0, 0, 9, 0, 0, 9}})")
    world.lua(f"sim.addParticleObjectItem({water}, {{0, 0, -1, 1, 0, -1}})")
    world.passes(2)
    place, velocity = flown(world, water)
    assert (place, velocity) == (pytest.approx([0.1, 0, -1]), pytest.approx([1, 0, 0])), "the newer one"
    world.lua(f"sim.addParticleObjectItem({water}, {{0, 0, 9, 1, 0, 9}})")
    world.passes(2)
    assert flown(world, water)[1][0] < 0.01


def test_particles_that_cannot_be_are_refused(world: ScriptWorld) -> None:
    world.fails("sim.addParticleObject(0, 0, 1, nil, 1, 1)", "size and density of particles are above 0")
    world.fails("sim.addParticleObject(0, 1, 1, {5}, 1, 1)", "pairs of a number and a value, not 1 numbers")
    world.lua(f"jet = {ADD % '0'}")
    world.fails("sim.addParticleObjectItem(jet, {0, 0, 1, 0, 0, 1 / 0})", "finite")


def test_viewers_draw_particles_that_are_visible(world: ScriptWorld) -> None:
    shown, hidden = world.lua(f"return {ADD % '0'}, {ADD % 'sim.particle_invisible'}")
    for handle in (shown, hidden):
        world.lua(f"sim.addParticleObjectItem({handle}, {{0, 0, 1, 0, 0, 1}})")
    ((handle, each),) = world.parts.particles.shown(10)
    assert (handle, each.color, each.sizes.tolist()) == (shown, (0.3, 0.7, 1.0), [0.005])
    assert world.parts.particles.shown(0) == []


def test_particles_end_with_the_run(world: ScriptWorld) -> None:
    handle = world.value(ADD % "0")
    world.sim.stop()
    world.run(0)
    world.fails(f"sim.removeParticleObject({handle})", "they end with the run")
