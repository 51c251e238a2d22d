"""How cost grows with the clients of one server: what a call takes, what the server computes, all calling at once."""

from __future__ import annotations

from contextlib import ExitStack, closing
from functools import partial

import simx_client as vrep
from bench.calls.blocking import message_sizes
from bench.calls.client import CAMERA, JOINTS, check, connected, handle_of
from bench.measuring import baselines, processes
from bench.measuring.measure import Effort, Rounds, ratio, repeated, side_by_side
from bench.measuring.report import Findings, Grid, Panel, Plot, Ratio, Row
from bench.measuring.resources import core_share, memory_mb, private_mb

from .crowd import crowd

COUNTS = (1, 2, 4, 8, 16, 32, 64)

MOST = 2.0
"""Times a read with one client, that a read beside many may take."""

READ = "blocking read"
QUERY = "bare Zenoh query"
SHARE = "server, % core"
ALONE = "server, nobody connected"
TOGETHER = "reads per second, all at once"
MEMORY, CROWD = "memory of the server", "memory of the clients' processes"


def measure(effort: Effort) -> Findings:
    """For each count a server of its own, whose clients all stream six joints while one more reads."""
    # One set each: starting so many clients takes most of the time.
    by_count = {count: repeated(1, partial(_one_set, effort, count)) for count in COUNTS}
    found = Findings("Cost against clients", topic="Many clients and servers")
    found.grids.append(
        Grid(
            ("clients", "read, us", "p99, us", QUERY, SHARE, "reads / s, all at once"),
            [
                (
                    str(count),
                    (
                        taken[READ].median * 1e6,
                        taken[READ].p99 * 1e6,
                        taken[QUERY].median * 1e6,
                        taken[SHARE].median * 100,
                        taken[TOGETHER].median,
                    ),
                )
                for count, taken in by_count.items()
            ],
        )
    )
    least = ratio(by_count[COUNTS[0]][READ], by_count[COUNTS[0]][QUERY])
    few, many = COUNTS[(len(COUNTS) - 1) // 2], COUNTS[-1]
    for count in (few, many):
        read, query = by_count[count][READ], by_count[count][QUERY]
        found.ratios.append(
            Ratio(f"a blocking read, {count} clients / 1 client", ratio(read, query) / least, target=MOST)
        )
    each = by_count[many][MEMORY].median / many
    found.rows.append(Row(f"memory of the server for each of {many} clients", each, None, "MB"))
    further = (by_count[many][CROWD].median - by_count[few][CROWD].median) / (many - few)
    found.rows.append(Row("memory of a client's process, for each further connection", further, None, "MB"))
    found.plots.append(_plot(by_count))
    found.notes.append(
        "Each client streams six joints of a simulation in real time; one more makes blocking reads. At once: all of "
        "them make blocking reads as fast as they can, from four processes on the same cores."
    )
    return found


def _plot(by_count: dict[int, dict[str, Rounds]]) -> Plot:
    def curve(name: str, scale: float, *, tail: bool = False) -> list[tuple[float, float]]:
        return [
            (count, (taken[name].p99 if tail else taken[name].median) * scale)
            for count, taken in by_count.items()
        ]

    calls = Panel(
        "a blocking read, us",
        "clients that stream six joints",
        {"median": curve(READ, 1e6), "99th percentile": curve(READ, 1e6, tail=True)},
        {f"{QUERY}, median": curve(QUERY, 1e6)},
        is_log=True,
    )
    share = Panel(
        "the server, % of a core, 20 simulation steps per second",
        "clients that stream six joints",
        {"all streaming": curve(SHARE, 100)},
        {"nobody connected": curve(ALONE, 100)},
    )
    return Plot("clients", [calls, share])


def _one_set(effort: Effort, count: int, stack: ExitStack) -> dict[str, Rounds]:
    server = stack.enter_context(processes.server("--start"))
    with connected(server.port) as first:
        check(vrep.simxGetVisionSensorImage(first, handle_of(first, CAMERA), 0, vrep.simx_opmode_blocking))
    span = max(0.2, effort.seconds(0.8))
    alone, before = core_share([server.process_id], span), private_mb(server.process_id)
    some = stack.enter_context(crowd(server.port, count))
    some.stream()
    share = core_share([server.process_id], span)
    memory = private_mb(server.process_id) - before
    reader = stack.enter_context(connected(server.port))
    far = stack.enter_context(processes.baseline(baselines.QUERY))
    query = stack.enter_context(closing(baselines.Query(far.port)))
    handle = handle_of(reader, JOINTS[0])
    request = baselines.request_of(*message_sizes(handle))
    taken = side_by_side(
        f"{count} clients",
        {
            READ: lambda: check(vrep.simxGetJointPosition(reader, handle, vrep.simx_opmode_blocking)),
            QUERY: lambda: query.exchange(request),
        },
        rounds=max(effort.rounds, effort.sets // 2),
        calls=effort.count(400, least=20),
    )
    together = some.calls_per_second(max(5, effort.count(2000) // count))
    single = {
        SHARE: share,
        ALONE: alone,
        TOGETHER: together,
        MEMORY: memory,
        CROWD: memory_mb(some.process_ids),
    }
    return taken | {name: Rounds(((value,),)) for name, value in single.items()}
