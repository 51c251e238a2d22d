"""The sensors of V-REP's own files, as scripts and clients read them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from handler_calls import World, floats
from ray_painter import RayPainter
from real_world import render_with
from vrep_samples import close_worlds, decoded, sample

from simx_server.scene.formats.loader import build
from simx_server.scene.formats.vrep.converting import convert

Box = tuple[Sequence[float], Sequence[float], Sequence[float]]
"""Position, half sizes and colour."""


@pytest.fixture(autouse=True)
def _ended() -> Iterator[None]:
    yield
    close_worlds()


def world_with(name: str, *boxes: Box, steps: int = 2) -> World:
    """A running world of a sample, with boxes around it."""
    path = sample(name)
    spec, _ = convert(decoded(path))
    for place, size, colour in boxes:
        body = spec.worldbody.add_body(pos=place)
        body.add_geom(type=6, size=size, rgba=[*colour, 1.0])
    world = World()
    world.sim.use(*build(spec, path))
    render_with(world, RayPainter())
    world.run(steps)
    return world


def packets(world: World, name: str) -> list[list[float]]:
    return world.call("simxReadVisionSensor", world.handle(name))[1]


def test_line_followers_see_the_dark_line_between_them() -> None:
    world = world_with("MyLineFollower.ttt")
    try:
        for number in ("", "#0", "#1", "#2", "#3"):
            means = [packets(world, f"{side}_sensor{number}")[0][10] for side in ("left", "middle", "right")]
            assert means[1] < 0.1
            assert min(means[0], means[2]) > 0.5
            assert len(packets(world, f"middle_sensor{number}")[1]) == 5
    finally:
        world.parts.scripts.close()


def test_fast_laser_scanner_measures_a_wall_with_the_depth_alone() -> None:
    world = world_with("Hokuyo URG 04LX UG01_Fast.ttm", ((2.1, 0, 0.2), (0.1, 3, 0.5), (1, 0, 0)))
    for name, side in (("fastHokuyo_sensor1", 1), ("fastHokuyo_sensor2", -1)):
        first, points = packets(world, name)
        assert first == []
        assert points[:2] == [342, 1]
        found = np.array(points[2:]).reshape(342, 4)
        met = found[found[:, 3] < 4.99]
        assert len(met) > 100
        # The wall is 2 m ahead of the scanner, which stands at x = 0; each sensor looks 60 degrees to its side.
        ahead = met[:, 2] * math.cos(math.radians(60)) + side * met[:, 0] * math.sin(math.radians(60))
        assert ahead == pytest.approx(np.full(len(met), ahead.mean()), abs=0.05)
        assert ahead.mean() == pytest.approx(2.0, abs=0.02)
        grey = world.call("simxGetVisionSensorImage", world.handle(name), 1)[1]
        depth = floats(world.call("simxGetVisionSensorDepthBuffer", world.handle(name))[1])
        assert list(grey) == pytest.approx([255 * value for value in depth], abs=0.51)


def test_blob_camera_counts_blobs_and_paints_them_apart() -> None:
    red, blue = (1, 0, 0), (0, 0, 1)
    size = (0.05, 0.05, 0.05)
    world = world_with(
        "Blob detection camera.ttm", ((0.05, 0.4, 0.05), size, red), ((-0.15, 0.6, 0.1), size, blue)
    )
    name = "blobDetectionCamera_camera"
    first, found = packets(world, name)
    assert first == []
    assert found[:2] == [2, 6]
    assert len(found) == 14
    width, height = world.call("simxGetVisionSensorImage", world.handle(name), 0)[0]
    data = world.call("simxGetVisionSensorImage", world.handle(name), 0)[1]
    colours = {tuple(pixel) for pixel in np.frombuffer(data, np.uint8).reshape(-1, 3).tolist()}
    assert (width, height) == (128, 128)
    assert len(colours) == 3  # black and one for each blob
    assert set(floats(world.call("simxGetVisionSensorDepthBuffer", world.handle(name))[1])) == {1.0}


def test_velodyne_scans_what_its_sensors_see() -> None:
    world = world_with("velodyne VPL-16.ttm", ((2.1, 0, 0.2), (0.1, 3, 0.5), (1, 0, 0)), steps=0)
    name = "velodyneVPL_16_sensor1"
    world.parts.vision.handle(world.handle(name))
    first, points = packets(world, name)
    assert first == []
    assert points[:2] == [1000, 16]
    found = np.array(points[2:]).reshape(-1, 4)
    met = found[found[:, 3] < 99]
    assert met[:, 2] == pytest.approx(np.full(len(met), 1.9), abs=0.15)


def test_proximity_sensor_tells_the_distance_of_a_box() -> None:
    world = world_with("proximity_sensor.ttt")
    detected, point, seen, _ = world.call("simxReadProximitySensor", world.handle("Proximity_sensor"))
    world.parts.scripts.close()
    assert detected
    assert point == pytest.approx([0, 0, 0.25], abs=1e-6)
    assert world.sim.scene.get(seen).name == "Cuboid"


def test_bubble_rob_s_nose_detects_within_its_cone() -> None:
    nose = "remoteApiControlledBubbleRobSensingNose"
    world = world_with("controlledViaLegacyRemoteApi.ttt", steps=1)
    handle = world.handle(nose)
    position = np.array(world.call("simxGetObjectPosition", handle, -1))
    assert not world.call("simxReadProximitySensor", handle)[0]
    matrix = world.sim.data.site(nose).xmat.reshape(3, 3)
    near = world_with(
        "controlledViaLegacyRemoteApi.ttt",
        (tuple(position + 0.12 * matrix[:, 2]), (0.01, 0.01, 0.01), (1, 1, 1)), steps=1,
    )  # fmt: skip
    detected, point, _, _ = near.call("simxReadProximitySensor", near.handle(nose))
    assert detected
    assert 0.1 < point[2] < 0.12


def test_two_dimensional_scanner_sends_the_points_of_a_wall() -> None:
    world = world_with("2D laser scanner.ttm", ((1.1, 0, 0.1), (0.1, 5, 0.5), (1, 0, 0)), steps=1)
    tube = world.parts.tubes.open(0, "LaserScanner_2D_2D_SCANNER_DATA", 10)
    for _ in range(2):
        world.parts.step()
    points = np.array(floats(world.parts.tubes.read(tube) or b"")).reshape(-1, 3)
    assert len(points) == 182  # rays over 90 degrees, two for each degree; the frame of the model has y ahead
    assert points[:, 1] == pytest.approx(np.ones(182), abs=1e-4)
    assert (points[:, 2].min(), points[:, 2].max()) == (
        pytest.approx(-1.0, abs=1e-3),
        pytest.approx(1.018, abs=1e-3),
    )
