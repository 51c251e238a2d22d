"""A ring of proximity sensors: what a pass costs when all of them are read, beside one in which none is."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial

from bench.measuring.measure import Effort, Rounds, difference, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Ratio, Row
from simx_server.app.server import open_world
from simx_server.scene.objects import ObjectKind
from simx_server.settings.settings import Settings

SCENE = "pioneer_p3dx"
"""Sixteen cones of 30 degrees and 1 m, among walls, boxes and cylinders."""
MOST = 4.0
"""Times one cone, that a ring of sixteen may take."""

PASS = "a pass, no sensor read"
ONE = "a pass, one cone read"
RING = "a pass, the ring of 16 cones read"
RING_ALONE = "the ring beyond the pass"


def measure(effort: Effort) -> Findings:
    """In process, so that nothing but the sensors is between the cases."""
    taken = repeated(effort.sets, partial(_one_set, effort))
    ring = difference(taken[RING], taken[PASS])
    found = Findings("Proximity sensors", topic="Simulation step")
    found.ratios = [
        Ratio("ring of 16 cones / one cone", ratio(ring, difference(taken[ONE], taken[PASS])), target=MOST),
        Ratio("ring of 16 cones / a simulation step without them", ratio(ring, taken[PASS])),
    ]
    found.rows = [Row.of(what, rounds, "us") for what, rounds in taken.items()]
    found.rows.append(Row.of(RING_ALONE, ring, "us"))
    return found


def _one_set(effort: Effort, stack: ExitStack) -> dict[str, Rounds]:
    simulation = open_world(Settings(scene=SCENE), stack)
    simulation.simulation.start()
    stack.callback(simulation.simulation.stop)
    ring = list(simulation.simulation.scene.of_kind(ObjectKind.PROXIMITY_SENSOR))

    def read(handles: list[int]) -> None:
        simulation.step()
        for handle in handles:
            simulation.proximity.read(handle)

    read(ring)  # the triangles are made
    return side_by_side(
        "sensors",
        {PASS: simulation.step, ONE: partial(read, ring[:1]), RING: partial(read, ring)},
        rounds=effort.rounds,
        calls=effort.count(100, 20),
    )
