"""V-REP's scene `ur5WithRg2Grasping`: an arm takes cuboids from a belt and lays them crosswise on one another."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from bench.motion.opened import Running, running
from simx_server.scene.poses.frames import get_pose
from simx_server.scene.poses.poses import rotate

SECONDS = 150.0
"""Time in which the script of the scene should have stopped the simulation."""

_CUBOIDS = ("Cuboid", *(f"Cuboid{number}" for number in range(5)))
_THICK = 0.05
"""Metres."""


@dataclass(frozen=True)
class Tower:
    """What the arm has built."""

    layers: tuple[int, ...]
    """Number of cuboids that lie in each layer, from the floor."""
    tilt: float
    """Greatest angle between a cuboid's long side and the level, rad."""
    seconds: float
    """When the script has stopped the simulation; `SECONDS` if it has not."""
    share: float


def build_tower(file: Path) -> Tower:
    """Run the scene until its script ends it."""
    with running(str(file)) as scene:
        simulation = scene.world.simulation
        while simulation.is_running and simulation.time < SECONDS:
            scene.step(1)
            if simulation.is_running:
                heights, tilt, seconds = *_look(scene), simulation.time
        layers = [round((height - _THICK / 2) / _THICK) for height in heights]
        lying = [layers.count(each) for each in range(max(layers) + 1)]
        return Tower(tuple(lying), tilt, seconds, scene.share)


def _look(scene: Running) -> tuple[list[float], float]:
    """Return the heights of the cuboids and the greatest angle of their long sides to the level."""
    poses = [get_pose(scene.world.simulation, scene.handle(name)) for name in _CUBOIDS]
    tilt = max(abs(math.asin(rotate(turn, (0.0, 0.0, 1.0))[2])) for _, turn in poses)
    return [place[2] for place, _ in poses], tilt
