"""Particle objects: kept, counted, and said to be no more than that."""

from __future__ import annotations

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


def test_the_log_says_once_what_particles_do_not_do(world: ScriptWorld) -> None:
    def lines(part: str) -> int:
        return sum(part in line for line in world.parts.status_bar.messages)

    world.lua(f"{ADD % '0'} {ADD % '0'}")
    assert (lines("are not shown"), lines("do not push")) == (1, 0)
    world.lua(ADD % "sim.particle_respondable1to4")
    assert (lines("are not shown"), lines("do not push")) == (1, 1)


def test_particles_end_with_the_run(world: ScriptWorld) -> None:
    handle = world.value(ADD % "0")
    world.sim.stop()
    world.run(0)
    world.fails(f"sim.removeParticleObject({handle})", "they end with the run")
