"""What a page in the browser costs the simulation: nobody looks, one does, ten do."""

from __future__ import annotations

import math
import time
from collections import Counter, defaultdict
from contextlib import ExitStack
from functools import partial

import msgpack

import simx_client as vrep
from bench.calls.client import check, connected, running, settle
from bench.measuring import processes
from bench.measuring.measure import Effort, Rounds, ratio, ratio_p99, side_by_side, timed
from bench.measuring.report import Findings, Grid, Ratio, Row
from simx_server.app.server import open_world
from simx_server.handlers import HANDLERS
from simx_server.service.clock import Pacer
from simx_server.service.service import build_service
from simx_server.settings.settings import Settings
from simx_server.viewer import messages
from simx_server.viewer.feed import Feed

from .lookers import looking
from .servers import simulated

LOOK = "an image of the scene (look), on the simulating thread"
SURVEY = "what the panels show (survey), on the simulating thread"
PASS = "a simulation step in process"
MOST = 0.6
"""Simulation steps of the tutorial's scene, that either may take: 300 us where a step takes 0.5 ms."""

NO_PAGE = "no page"
LOOKERS = {"a page, nobody looks": 0, "one looks": 1, "ten look": 10}
HEAD = ("page", "passes / s", "of those without", "stepped pass, x", "its p99, x", "kB / s for each")
_TIME_STEP = 0.05
Times = tuple[float, ...]


def measure(effort: Effort) -> Findings:
    """The tutorial's scene, as fast as it goes. Who looks draws nothing: browsers are on other machines."""
    found = Findings("A page in the browser", topic="Many clients and servers")
    costs = _in_process(effort)
    passes: defaultdict[str, list[float]] = defaultdict(list)
    steps: defaultdict[str, list[Times]] = defaultdict(list)
    traffic: defaultdict[str, float] = defaultdict(float)

    def measure_one(name: str) -> None:
        passes[name].append(_seconds_each(effort, client))
        steps[name].append(_steps(effort, client))

    with ExitStack() as stack:
        server = stack.enter_context(processes.server("--speed", "max"))
        client = stack.enter_context(connected(server.port))
        settle(client)
        _steps(effort, client)  # its first passes are slow
        measure_one(NO_PAGE)
        with processes.page(server) as page:
            for name in (*LOOKERS, *reversed(LOOKERS)):
                heard = Counter[str]()
                with ExitStack() as looks:
                    if count := LOOKERS[name]:
                        url = f"http://127.0.0.1:{page.port}/"
                        looks.enter_context(
                            looking(url, count, lambda _, window, to=heard: to.update(bytes=len(window)))
                        )
                    heard.clear()  # the scene as a whole
                    began = time.perf_counter()
                    measure_one(name)
                    took = time.perf_counter() - began
                    traffic[name] += heard["bytes"] / took / max(1, count) / 1e3 / 2
        measure_one(NO_PAGE)
    rates = {name: Rounds(tuple((each,) for each in seconds)) for name, seconds in passes.items()}
    times = {name: Rounds(tuple(each)) for name, each in steps.items()}
    found.ratios = [
        Ratio(f"{name} / {PASS}", ratio(costs[name], costs[PASS]), target=MOST) for name in (LOOK, SURVEY)
    ]
    found.rows = [Row.of(name, each, "us") for name, each in costs.items()]
    found.grids.append(
        Grid(
            HEAD,
            [
                (
                    name,
                    (
                        1 / rates[name].median,
                        ratio(rates[NO_PAGE], rates[name]),
                        ratio(times[name], times[NO_PAGE]),
                        ratio_p99(times[name], times[NO_PAGE]),
                        traffic[name] if LOOKERS.get(name) else None,
                    ),
                )
                for name in (NO_PAGE, *LOOKERS)
            ],
        )
    )
    found.notes.append(
        "Whoever looks has 25 images a second made, and 5 updates of the panels. Server, page, client and lookers "
        "share the cores of one machine here, so what the page's process computes counts as well."
    )
    return found


def _in_process(effort: Effort) -> dict[str, Rounds]:
    """The feed's two questions, as they are asked again and again."""
    with ExitStack() as stack:
        simulation = open_world(Settings(), stack)
        feed = Feed(build_service(simulation, HANDLERS, Pacer(math.inf)), "bench", [0])
        simulation.simulation.start()
        stack.callback(simulation.simulation.stop)
        simulation.step()
        first = msgpack.unpackb(feed.call(messages.LOOK, [-1, -1], [], [], b"")[3])
        look = partial(feed.call, messages.LOOK, [first["model"], first["arrays_version"]], [], [], b"")
        first = msgpack.unpackb(feed.call(messages.SURVEY, [-1, -1], [], [], b"")[3], strict_map_key=False)
        survey = partial(
            feed.call, messages.SURVEY, [first["tree_version"], first["drawings_version"]], [], [], b""
        )
        return side_by_side(
            "view",
            {LOOK: look, SURVEY: survey, PASS: simulation.step},
            rounds=effort.rounds,
            calls=effort.count(300, 20),
        )


def _seconds_each(effort: Effort, client: int) -> float:
    """Of the passes of a run that nobody steps."""
    with running(client):
        before, began = simulated(client), time.perf_counter()
        time.sleep(max(0.2, effort.seconds(0.5)))
        return (time.perf_counter() - began) / (simulated(client) - before) * _TIME_STEP


def _steps(effort: Effort, client: int) -> Times:
    """Seconds for each pass that the client asks for."""
    with running(client, stepped=True):
        taken = timed(lambda: check(vrep.simxSynchronousTrigger(client)), effort.count(150, 20))
    check(vrep.simxSynchronous(client, False))
    return taken
