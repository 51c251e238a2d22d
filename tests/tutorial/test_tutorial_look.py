"""The tutorial's picture as V-REP shows it: the stained floor, flat faces without a sheen, where things stand."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Iterator
from types import ModuleType

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from processes import ROOT
from real_world import BLOCKING, RealWorld, handle_of, start_stepped, step

import simx_client as vrep
from simx_server.sensors.opengl.backend import choose_backend

pytestmark = [pytest.mark.slow, pytest.mark.gl]

POSE = np.radians([95.98, -55.02, 85.55, 9.75, -87.13, 0.5])
"""The arm where the tutorial's author took his picture."""

FOCAL = 320 / math.tan(math.radians(57) / 2)
YELLOW = (-0.644, 0.274)

CameraImage = NDArray[np.int64]


def floor_texture() -> ModuleType:
    """docs/floor_texture.py, which is not part of a package."""
    spec = importlib.util.spec_from_file_location("floor_texture", ROOT / "docs" / "floor_texture.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class View:
    """The image of the hand camera, and which pixel shows a point of the world."""

    def __init__(self, world: RealWorld, client: int) -> None:
        self.client = client
        sensor = handle_of(client, "kinect_rgb")
        code, resolution, image = vrep.simxGetVisionSensorImage(client, sensor, 0, BLOCKING)
        assert (code, resolution) == (vrep.simx_return_ok, [640, 480])
        self.picture: CameraImage = np.array(image, dtype=np.uint8).reshape(480, 640, 3)[::-1].astype(int)
        camera = world.simulation.data.camera("kinect_rgb")
        self._place, self._axes = camera.xpos.copy(), camera.xmat.reshape(3, 3).copy()

    def pixels(self, points: NDArray[np.float64]) -> CameraImage:
        """(n, 3) colours of points (n, 3) that are in the picture; those outside are left out."""
        x, y, z = self._axes.T @ (points - self._place).T
        column, row = np.rint(320 - FOCAL * x / z), np.rint(240 + FOCAL * y / z)
        seen = (z < 0) & (column >= 0) & (column < 640) & (row >= 0) & (row < 480)
        return self.picture[row[seen].astype(int), column[seen].astype(int)]


@pytest.fixture(scope="module", params=["opengl", "raycast"])
def view(request: pytest.FixtureRequest) -> Iterator[View]:
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "raycast":
            patch.setenv("MUJOCO_GL", "disable")
        elif choose_backend().name == "raycast":
            pytest.skip("no OpenGL on this machine: apt-get install libegl1 libopengl0 libgl1-mesa-dri")
        world = RealWorld("ur5_rg2_kinect")
        client = world.client()
        try:
            for number, angle in enumerate(POSE, 1):
                joint = handle_of(client, f"UR5_joint{number}")
                vrep.simxSetJointPosition(client, joint, angle, BLOCKING)
                vrep.simxSetJointTargetPosition(client, joint, angle, BLOCKING)
            start_stepped(client)
            step(client, 1.0)
            yield View(world, client)
        finally:
            world.close()


def grid(low: tuple[float, float], high: tuple[float, float], z: float) -> NDArray[np.float64]:
    x, y = np.meshgrid(np.linspace(low[0], high[0], 60), np.linspace(low[1], high[1], 60))
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)])


def test_the_lilac_cuboids_top_has_no_sheen(view: View) -> None:
    top = view.pixels(grid((-0.88, -0.53), (-0.82, -0.47), 0.2))
    assert len(top) > 500
    assert np.abs(top - (186, 187, 218)).max() <= 3


def test_the_yellow_cylinder_stands_where_it_does_in_v_rep(view: View) -> None:
    handle = handle_of(view.client, "Cylinder0")
    place = vrep.simxGetObjectPosition(view.client, handle, -1, BLOCKING)[1]
    assert place == pytest.approx([*YELLOW, 0.1], abs=5e-4)
    for x, y in ((-1, 0), (0, -1), (0, 1)):  # the far edge of its top, and both sides
        for radius in (0.095, 0.108):
            (colour,) = view.pixels(np.array([[YELLOW[0] + radius * x, YELLOW[1] + radius * y, 0.2]]))
            is_yellow = colour[0] > 140 and colour[2] < 60
            assert is_yellow == (radius < 0.1), (x, y, radius, colour)


def test_the_floor_is_stained_by_two_to_three_grey_levels(view: View) -> None:
    colours = []
    for low, high, expected in (
        ((-0.45, 0.15), (-0.3, 0.45), (197, 195, 188)),
        ((-0.45, -0.3), (-0.3, -0.05), (180, 177, 169)),
    ):
        tile = view.pixels(grid(low, high, 0.0))
        assert len(tile) > 2000
        assert tile.mean(axis=0) == pytest.approx(expected, abs=3)
        assert (tile.std(axis=0) > 1.5).all()
        assert (tile.std(axis=0) < 3.5).all()
        # Stains are of all colours alike.
        assert np.ptp(tile - tile.mean(axis=0), axis=1).max() < 3
        colours.append(tile)


def test_the_floors_texture_is_the_one_that_its_script_draws() -> None:
    script = floor_texture()
    drawn = script.texture().astype(int)
    image = cv2.imread(str(script.FILE))
    assert image is not None
    kept = image[:, :, ::-1].astype(int)
    assert np.abs(kept - drawn).max() <= 1  # FFTs of other machines may round otherwise


def test_the_stains_go_on_where_the_texture_is_repeated() -> None:
    stains = floor_texture().stains()
    assert stains.mean() == pytest.approx(0, abs=1e-9)
    for axis in (0, 1):
        inside = np.abs(np.diff(stains, axis=axis)).max()
        across = np.abs(np.take(stains, 0, axis) - np.take(stains, -1, axis)).max()
        assert across <= inside
