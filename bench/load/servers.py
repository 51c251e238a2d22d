"""How much more several servers of one command do together, and what memory they take."""

from __future__ import annotations

import time
from contextlib import ExitStack
from functools import partial

import simx_client as vrep
from bench.calls.client import check, connected
from bench.measuring.measure import Effort, Rounds, repeated, timed
from bench.measuring.report import Findings, Grid, Panel, Plot
from bench.measuring.resources import memory_mb
from bench.measuring.scheduling import cores
from simx_server.app.server import open_world
from simx_server.settings.settings import Settings

from .scale import fleet

COUNTS = (1, 2, 4, 8)

PASSES = "passes per second together"
IN_PROCESS = "passes per second in process, on all cores"
MEMORY = "memory"
HEAD = ("servers", PASSES, "of the cores' worth in process", "memory, MB", "with a parent each, MB")


def measure(effort: Effort) -> Findings:
    """The tutorial's scene, as fast as it goes."""
    sets = max(1, effort.sets // 3)
    taken = {count: repeated(sets, partial(_one_set, effort, count)) for count in COUNTS}
    found = Findings("Cost against servers", topic="Many clients and servers")

    def curve(name: str) -> list[tuple[float, float]]:
        return [(count, taken[count][name].median) for count in COUNTS]

    singles = [(float(count), count * taken[COUNTS[0]][MEMORY].median) for count in COUNTS]
    found.grids.append(
        Grid(
            HEAD,
            [
                (
                    str(count),
                    (
                        taken[count][PASSES].median,
                        taken[count][PASSES].median / taken[count][IN_PROCESS].median,
                        taken[count][MEMORY].median,
                        singles[place][1],
                    ),
                )
                for place, count in enumerate(COUNTS)
            ],
        )
    )
    found.plots.append(
        Plot(
            "servers",
            [
                Panel(
                    PASSES,
                    "servers of one command",
                    {"servers": curve(PASSES)},
                    {"in process": curve(IN_PROCESS)},
                ),
                Panel(
                    "memory of all, MB",
                    "servers of one command",
                    {"servers of one command": curve(MEMORY)},
                    {"as many with a parent each": singles},
                ),
            ],
        )
    )
    found.notes.append(
        "In process: the passes of one simulation without a server, times the cores that so many can use. Nobody is "
        "connected but who asks for the time."
    )
    return found


def _one_set(effort: Effort, count: int, stack: ExitStack) -> dict[str, Rounds]:
    span = max(0.2, effort.seconds(0.8))
    in_process = _in_process(effort)
    many = stack.enter_context(fleet(count, "--start", "--speed", "max"))
    clients = [stack.enter_context(connected(port)) for port in many.ports]
    before, began = sum(map(simulated, clients)), time.perf_counter()
    time.sleep(span)
    passed, took = sum(map(simulated, clients)) - before, time.perf_counter() - began
    step = vrep.simxGetFloatingParameter(
        clients[0], vrep.sim_floatparam_simulation_time_step, vrep.simx_opmode_blocking
    )
    figures = {
        PASSES: passed / float(check(step)[1]) / took,
        IN_PROCESS: in_process * min(count, cores()),
        MEMORY: memory_mb([many.parent, *many.process_ids]),
    }
    return {name: Rounds(((value,),)) for name, value in figures.items()}


def _in_process(effort: Effort) -> float:
    """Passes per second of one simulation."""
    with ExitStack() as stack:
        simulation = open_world(Settings(), stack)
        simulation.simulation.start()
        stack.callback(simulation.simulation.stop)
        calls = effort.count(300)
        return calls / sum(timed(simulation.step, calls))


def simulated(client: int) -> float:
    """Seconds so far."""
    check(vrep.simxGetPingTime(client))
    return vrep.simxGetLastCmdTime(client) / 1000
