"""The counts of a server, and how it reports them."""

from __future__ import annotations

import json
import logging
import random
from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_world import World
from processes import PENDULUM

import simx_client as v
from simx_client.protocol.codec import CodecError, encode
from simx_client.protocol.messages import Batch, Call
from simx_client.protocol.reports import decode_health, decode_metrics, encode_report
from simx_server.durations import BOUNDS, MAX_CAMERAS, OTHERS, Histogram, ImageTimes, percentiles
from simx_server.scene.cameras.image import CameraImage, CameraView, Renderer, RenderError
from simx_server.sensors.opengl.backend import Backend
from simx_server.sensors.rendering.render_thread import RenderThread
from simx_server.service.calls.work import BatchWork
from simx_server.service.clock import Pacer
from simx_server.service.monitoring import report
from simx_server.service.monitoring.metrics import UNKNOWN, Metrics

BLOCKING = v.simx_opmode_blocking


@pytest.fixture
def world() -> Iterator[World]:
    world = World()
    yield world
    world.close()


def told(world: World) -> Any:
    """The metrics as an operator gets them."""
    return decode_metrics(encode_report(report.metrics(world.loop.service, "lab", [19997])))


class Clock:
    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


# --- counting -------------------------------------------------------------------------------------


def test_calls_and_failures_are_counted_by_command_and_client(world: World) -> None:
    one, other = world.client(), world.client()
    for _ in range(5):
        v.simxGetJointPosition(one, 1, BLOCKING)
    v.simxGetJointPosition(other, -1, BLOCKING)
    v.simxCallScriptFunction(other, "x", 1, "crash", [], [], [], b"", BLOCKING)
    metrics = told(world)
    joint, script = metrics["commands"]["simxGetJointPosition"], metrics["commands"]["simxCallScriptFunction"]
    assert (joint["count"], joint["failed"], joint["internal"]) == (6, 1, 0)
    assert joint["last_error"] == "simxGetJointPosition: no object with handle -1"
    assert (script["count"], script["failed"], script["internal"]) == (1, 1, 1)
    assert 0 < joint["p50"] <= joint["p90"] <= joint["p99"] <= joint["longest"] <= joint["seconds"]
    assert metrics["calls"]["count"] == 7
    assert metrics["calls"]["failed"] == 2
    assert metrics["calls"]["per_second"] > 0
    assert [client["calls"] for client in metrics["clients"]] == [5, 2]
    assert metrics["realm"] == "lab"
    assert metrics["state"] == "stopped"
    assert metrics["process"]["memory"] > 1_000_000


def test_whatever_is_refused_is_counted_as_well_and_under_the_name_of_the_table(world: World) -> None:
    client = world.client()
    calls = [
        ("simxGetJointPosition", [1]),
        ("simxGetJointPosition", ["one"]),
        ("simxGetJointPosition", [-1]),
        ("simxInvented", []),
        ("simxGetJointPosition", []),
        ("simxJointGetForce", [1]),  # an alias; this world has no handler for it
        ("simxGetJointForce", [1]),
    ]
    batch = Batch(1, 0, [Call(number, 0, 0, *call) for number, call in enumerate(calls, 1)])
    world.loop.service.queue.submit(world.transports[client].client, BatchWork(encode(batch)))
    world.settle()
    metrics = told(world)
    counts = {name: (each["count"], each["failed"]) for name, each in metrics["commands"].items()}
    assert counts == {"simxGetJointPosition": (4, 3), "simxGetJointForce": (2, 2), UNKNOWN: (0, 1)}
    assert metrics["clients"][0]["commands"] == {
        "simxGetJointPosition": 4,
        "simxGetJointForce": 2,
        UNKNOWN: 1,
    }


def test_streams_and_passes_are_counted(world: World) -> None:
    client = world.client()
    v.simxStartSimulation(client, BLOCKING)
    v.simxGetJointPosition(client, 1, v.simx_opmode_streaming)
    for _ in range(4):
        world.settle()
    before = told(world)
    for _ in range(3):
        world.settle()
    metrics = told(world)
    assert metrics["steps"]["count"] - before["steps"]["count"] == 3
    assert metrics["steps"]["simulated"] == pytest.approx(metrics["steps"]["count"] * 0.05)
    assert metrics["steps"]["speed"] is None
    assert metrics["streams"] == metrics["clients"][0]["streams"] == 1
    name = "simxGetJointPosition"
    assert metrics["commands"][name]["count"] - before["commands"][name]["count"] == 3
    assert metrics["calls"]["count"] == before["calls"]["count"]  # a stream is one call


def test_a_client_that_left_is_forgotten_and_its_calls_are_not(world: World) -> None:
    client = world.client()
    v.simxGetJointPosition(client, 1, BLOCKING)
    v.simxFinish(client)
    world.settle()
    metrics = told(world)
    assert metrics["clients"] == []
    assert metrics["calls"]["count"] >= 1
    assert metrics["commands"]["simxGetJointPosition"]["count"] == 1
    assert world.loop.service.metrics.client_calls == {}


def test_a_viewer_is_told_from_a_driver(world: World) -> None:
    world.loop.service.clients.join("viewer-1", "watcher", 7, SimpleNamespace(close=lambda: None))  # pyright: ignore
    (client,) = told(world)["clients"]
    assert (client["name"], client["role"], client["port"]) == ("watcher", "viewer", 7)


def test_names_that_are_no_commands_share_one_place() -> None:
    metrics = Metrics(Pacer(1.0))
    for number in range(100):
        metrics.executed(f"nonsense {number}", 1e-6)
        metrics.failed(f"nonsense {number}", "there is none")
    assert list(metrics.command_times) == list(metrics.failures) == [UNKNOWN]
    assert metrics.failures[UNKNOWN].failed == 100


def test_cameras_are_not_counted_without_end() -> None:
    times = ImageTimes()
    for number in range(MAX_CAMERAS + 10):
        times.made(f"camera {number}", 0.001)
    assert len(times.by_camera) == MAX_CAMERAS + 1
    assert sum(times.by_camera[OTHERS].counts) == 10


def test_percentiles_are_within_ten_percent() -> None:
    chance = random.Random(1)
    durations = sorted(10 ** chance.uniform(-5.5, 1.5) for _ in range(5000))
    histogram = Histogram()
    for duration in durations:
        histogram.add(duration)
    exact = [durations[int(share * len(durations))] for share in (0.5, 0.9, 0.99)]
    assert percentiles(histogram.counts) == pytest.approx(exact, rel=0.1)
    assert percentiles([0] * len(histogram.counts)) == [0, 0, 0]
    histogram.add(1e-9)
    histogram.add(1e9)
    assert histogram.counts[0] == histogram.counts[len(BOUNDS)] == 1


def test_recent_figures_forget_what_is_over(world: World) -> None:
    clock = Clock()
    metrics = Metrics(Pacer(1.0), clock, clock)
    service = replace(world.loop.service, metrics=metrics)

    def live(seconds: int, *, calls: int, each: float) -> None:
        for _ in range(seconds):
            for _ in range(calls):
                metrics.called("c", 1)
                metrics.executed("simxGetObjects", each)
            metrics.passed(0.5, 0.01)
            clock.now += 1.0
            metrics.look()

    live(20, calls=100, each=0.001)
    live(8, calls=10, each=0.1)
    said = report.metrics(service, "lab", [])
    assert said["window"] == pytest.approx(5.0)
    assert said["calls"]["per_second"] == pytest.approx(10.0)
    assert said["steps"]["per_second"] == pytest.approx(1.0)
    assert said["steps"]["real_time_factor"] == pytest.approx(0.5)
    assert said["process"]["core_share"] == pytest.approx(1.0)
    times = said["commands"]["simxGetObjects"]
    assert times["count"] == 2080
    assert times["p50"] == pytest.approx(0.001, rel=0.1)
    assert times["recent"]["p50"] == pytest.approx(0.1, rel=0.1)
    assert times["recent"]["per_second"] == pytest.approx(10.0)
    live(8, calls=0, each=0.0)
    nothing = {"per_second": 0, "p50": 0, "p90": 0, "p99": 0}
    assert report.metrics(service, "lab", [])["commands"]["simxGetObjects"]["recent"] == nothing


def test_a_running_engine_takes_a_sample_now_and_then(world: World) -> None:
    clock = Clock()
    metrics = Metrics(Pacer(1.0), clock, clock)
    world.loop.service.watchers.add(metrics)
    for _ in range(7):
        clock.now += 1.0
        world.loop.service.ending.request()
        world.loop.run()
        world.loop.service.ending.has_come = False
    assert metrics.recent().wall == clock.now - 5.0


# --- problems -------------------------------------------------------------------------------------


def test_a_simulation_that_cannot_keep_up_is_told_as_a_problem(world: World) -> None:
    clock = Clock()
    pacer = Pacer(2.0, clock)
    service = replace(world.loop.service, metrics=Metrics(pacer, clock))
    assert report.health(service, "lab")["problems"] == []
    pacer.restart()
    for _ in range(3):
        clock.now += 0.5
        pacer.passed(0.05)
    (problem,) = report.health(service, "lab")["problems"]
    assert "cannot keep up with speed 2" in problem
    assert report.metrics(service, "lab", [])["steps"]["lost"] == pytest.approx(1.5, abs=0.2)
    for _ in range(10):  # over
        clock.now += 1.0
        service.metrics.look()
    assert report.health(service, "lab")["problems"] == []


def test_logged_errors_are_counted_and_told(world: World) -> None:
    with world.loop.service.metrics.log.attached():
        logging.getLogger("simx_server.anything").warning("careful: %d", 5)
        logging.getLogger("simx_client.anything").error("broken")
        logging.getLogger("simx_server.anything").info("all is well")
    logging.getLogger("simx_server.anything").error("nobody counts this any more")
    log = told(world)["log"]
    assert log == {"warnings": 1, "errors": 1, "last_warning": "careful: 5", "last_error": "broken"}
    (problem,) = report.health(world.loop.service, "lab")["problems"]
    assert "1 errors were logged" in problem


class OneGoodPicture:
    """A renderer that breaks with the second picture."""

    def __init__(self) -> None:
        self.made = 0

    def render(self, data: Any, view: CameraView, rgb: bool, depth: bool, _let_in: Any) -> CameraImage:
        self.made += 1
        if self.made > 1:
            raise RuntimeError("the driver is gone")
        return CameraImage(rgb=np.zeros((view.height, view.width, 3), np.uint8), depth=None)

    def rest(self) -> None: ...

    def close(self) -> None: ...


def test_images_are_timed_by_the_name_of_their_camera(world: World) -> None:
    text = PENDULUM.replace("<worldbody>", '<worldbody><camera name="eye"/>')
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    renderer = OneGoodPicture()
    thread = RenderThread(lambda: Backend("egl", "a test"), lambda model, backend: cast(Renderer, renderer))
    world.loop.service.metrics.images = thread.times
    view = CameraView(0, 4, 4, 45.0, 0.1, 10.0)
    try:
        thread.request(model, data, view, rgb=True, depth=False, version=1).result(10)
        with pytest.raises(RenderError):
            thread.request(model, data, view, rgb=True, depth=False, version=2).result(10)
    finally:
        thread.close()
    images = told(world)["images"]
    assert images["cameras"]["eye"]["count"] == 1
    assert images["failed"] == 1
    assert "the driver is gone" in images["last_error"]
    assert any("images" in problem for problem in report.health(world.loop.service, "lab")["problems"])


# --- as it travels --------------------------------------------------------------------------------


def test_a_report_is_plain_json_and_may_have_more_in_a_later_version(world: World) -> None:
    said = json.loads(encode_report(report.metrics(world.loop.service, "lab", [1])))
    said["weather"] = "fine"
    said["steps"]["colour"] = 1
    assert decode_metrics(json.dumps(said).encode())["realm"] == "lab"
    assert decode_health(encode_report(report.health(world.loop.service, "lab")))["state"] == "stopped"


def test_a_report_of_version_0_4_is_read_by_its_own_names(world: World) -> None:
    said: Any = json.loads(encode_report(report.metrics(world.loop.service, "lab", [1])))
    now = decode_metrics(json.dumps(said).encode())
    said["passes"], said["pictures"] = said.pop("steps"), said.pop("images")
    assert decode_metrics(json.dumps(said).encode()) == now


@pytest.mark.parametrize(
    ("path", "value", "text"),
    [
        (("realm",), 5, "Metrics.realm must be str"),
        (("steps", "speed"), "fast", "Metrics.steps.speed must be float"),
        (("steps", "times", "recent"), [], "Metrics.steps.times.recent must be an object"),
        (("commands",), {"x": {}}, "Metrics.commands['x'].p50 is missing"),
        (("clients",), {}, "Metrics.clients must be a list"),
        (("clients",), [5], "Metrics.clients[] must be an object"),
    ],
)
def test_a_wrong_report_says_what_is_wrong(
    world: World, path: tuple[str, ...], value: Any, text: str
) -> None:
    said: Any = report.metrics(world.loop.service, "lab", [1])
    place = said
    for name in path[:-1]:
        place = place[name]
    place[path[-1]] = value
    with pytest.raises(CodecError) as wrong:
        decode_metrics(json.dumps(said).encode())
    assert text in str(wrong.value)


@given(st.one_of(st.binary(max_size=40), st.just(b"[" * 100_000), st.just(b"9" * 5000)))
def test_bytes_that_are_no_report_are_refused(payload: bytes) -> None:
    with pytest.raises(CodecError):
        decode_health(payload)
