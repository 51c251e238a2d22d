"""The tutorial's scene as a photographer's studio: each picture has another pose, another light, another ball.

The arm poses, and nothing moves on its own: the simulation runs in stepped mode and is never stepped. What the ball's
pixels are is not guessed from its colour or its place: the camera says which object each pixel shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simx_client import Client

JOINTS = tuple(f"UR5_joint{number}" for number in range(1, 7))
CAMERA, BALL, RADIUS = "kinect_rgb", "Target", 0.05
SOLIDS = {
    "Cuboid": 0.05,
    "Cuboid0": 0.1,
    "Cuboid1": 0.05,
    "Cuboid2": 0.05,
    "Cylinder": 0.075,
    "Cylinder0": 0.1,
}
"""The loose solids, and the height in m of each one's middle above the floor it stands on."""

VIEW = np.radians([90.0, -45.0, 90.0, 0.0, -100.0, 0.0])
SPREAD = np.radians([70.0, 15.0, 20.0, 15.0, 20.0, 25.0])
"""The tutorial's pose that sees the ball, and how far each joint may be from it, radians."""

DISTANCE = (0.35, 1.8)
"""Metres from the camera to the ball."""

LEAST_HEIGHT = 0.3
"""Metres above the floor that the camera keeps, so that the hand in front of it stays clear, too."""

WITHOUT_BALL = 0.12
"""Share of the pictures from which the ball is taken away; it is out of sight in some others."""

FAR_AWAY = (0.0, 0.0, -9.0)
CYAN = np.array([0.0, 0.85, 1.0])
"""The ball in the tutorial."""

LEAST_PIXELS = 20
"""A sliver of fewer pixels is not labelled."""

LOOK = """
sim.setShapeColor(sim.getObjectHandle('Target'), nil, sim.colorcomponent_ambient_diffuse, {{{ball}}})
sim.setObjectOrientation(sim.getObjectHandle('DefaultLights'), -1, {{0, 0, {turn}}})
for name, strength in pairs({{A = {a}, B = {b}, C = {c}, D = {d}}}) do
    sim.setLightParameters(sim.getObjectHandle('DefaultLight' .. name), 1, nil,
        {{strength * {red}, strength, strength * {blue}}}, {{strength, strength, strength}})
end
"""
"""Lua. V-REP's remote API knows neither lights nor colours; its scripts do."""


@dataclass(frozen=True)
class Shot:
    """One picture and what is known of the ball in it."""

    picture: NDArray[np.uint8]
    """(height, width, 3) RGB, the top row first."""
    mask: NDArray[np.bool_]
    """(height, width): where the ball is seen."""
    ball: NDArray[np.float64]
    """(3,) metres in the camera's frame: x left, y up, z ahead."""

    @property
    def box(self) -> tuple[float, float, float, float] | None:
        """Left, top, right, bottom edge in pixels of what is seen of the ball; None where that is next to nothing."""
        if self.mask.sum() < LEAST_PIXELS:
            return None
        rows, columns = np.flatnonzero(self.mask.any(axis=1)), np.flatnonzero(self.mask.any(axis=0))
        return float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1)


class Studio:
    """Takes shots; between `with client.stepping()` and its end."""

    def __init__(self, client: Client, seed: int) -> None:
        self._client = client
        self._random = np.random.default_rng(seed)
        self._arm = client.joints(*JOINTS)
        self._camera, self._ball = client.camera(CAMERA), client.object(BALL)
        self._solids = {client.object(name): height for name, height in SOLIDS.items()}
        width, height = self._camera.resolution
        self._half = (
            np.tan(self._camera.perspective_angle / 2) / max(width, height) * np.array([width, height])
        )

    def take(self) -> Shot:
        """Change everything, and take a picture.

        Raises:
            RemoteError: the server has another scene, or runs no code of clients.
        """
        self._change_look()
        self._pose()
        where = self._camera.pose
        with self._client.together():
            self._scatter()
            self._ball.position = self._place(where.matrix)
        return Shot(
            self._camera.rgb(),
            self._camera.objects() == self._ball.handle,
            self._ball.relative_to(self._camera).position,
        )

    def _change_look(self) -> None:
        """Another light; and in every second picture a ball of another colour than the tutorial's."""
        draw = self._random.uniform
        ball = CYAN * draw(0.8, 1.0) if draw() < 0.5 else draw(0.05, 1.0, 3)
        code = LOOK.format(
            ball=", ".join(f"{part:.3f}" for part in ball),
            turn=draw(-np.pi, np.pi),
            red=draw(0.8, 1.2),
            blue=draw(0.8, 1.2),
            **dict(zip("abcd", draw(0.1, 0.6, 4), strict=True)),
        )
        self._client.call("executeCode_function", "remoteApiCommandServer", strings=[code])

    def _pose(self) -> None:
        while True:
            self._arm.positions = VIEW + self._random.uniform(-SPREAD, SPREAD)
            if self._camera.position[2] > LEAST_HEIGHT:
                return

    def _scatter(self) -> None:
        """Put the loose solids elsewhere, some of them perhaps between ball and camera."""
        for solid, height in self._solids.items():
            x, y = self._random.uniform((-1.2, -1.0), (0.2, 0.6))
            solid.position = (x, y, height)

    def _place(self, camera: NDArray[np.float64]) -> NDArray[np.float64]:
        """A place for the ball, (3,) world, m: in the line of a random pixel, or just outside, and above the floor."""
        if self._random.uniform() < WITHOUT_BALL:
            return np.array(FAR_AWAY)
        across, up = self._random.uniform(-1.06, 1.06, 2) * self._half
        ray = camera[:3, :3] @ (across, up, 1.0)
        depth = self._random.uniform(*DISTANCE)
        if ray[2] < 0:
            depth = min(depth, (RADIUS - camera[2, 3]) / ray[2])
        return camera[:3, 3] + ray * depth
