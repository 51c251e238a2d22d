"""What is grasped: objects of RLBench's tasks and PyRep's scenes, and boxes that a program makes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from .program import WORLD, Array, Program

_MIN_X, _CUBOID, _DYNAMIC_RESPONDABLE = 15, 0, 8
"""The first of the parameters that are the corners of a shape's box; type and options of shapes."""


@dataclass(frozen=True)
class Thing:
    """An object to grasp."""

    name: str
    file: str = ""
    """In RLBench's folder `task_ttms`; none for a box."""
    size: tuple[float, float, float] = (0.05, 0.05, 0.05)
    """Of a box, m."""
    mass: float = 0.2
    """Of a box, kg."""
    grip: tuple[float, float] = (0.0, 0.5)
    """Where it is taken: metres along x from the middle of its box, and the part of its height."""

    def bring(self, program: Program, folder: Path) -> int:
        """Add it to the scene, free, and return its handle."""
        if not self.file:
            options = _DYNAMIC_RESPONDABLE
            return program.call("createPureShape", _CUBOID, options, list(self.size), self.mass)
        model = program.call("loadModel", str(folder / self.file))
        handle = program.handle(self.name)
        program.call("setObjectParent", handle, WORLD, True)
        program.call("removeModel", model)
        return handle


def corners(program: Program, handle: int) -> Array:
    """Return the lowest and highest coordinates in the world of a shape's box, 2 x 3, m."""
    values = [program.call("getObjectFloatParameter", handle, _MIN_X + number)[-1] for number in range(6)]
    low, high = np.array(values).reshape(2, 3)
    pose = program.pose(handle)
    placed = np.array(list(product(*zip(low, high, strict=True)))) @ pose[:, :3].T + pose[:, 3]
    return np.array([placed.min(axis=0), placed.max(axis=0)])


THINGS = (
    Thing("box of 200 g"),
    Thing("box of 500 g", mass=0.5),
    Thing("pick_and_lift_target", "pick_and_lift.ttm"),
    Thing("block_pyramid_block0", "block_pyramid.ttm"),
    Thing("item", "put_item_in_drawer.ttm"),
    Thing("cylinder", "pick_and_lift_small.ttm"),
    Thing("target_cuboid", "play_jenga.ttm"),
    Thing("cup1", "pick_up_cup.ttm", grip=(0.052, 0.83)),
)
"""Those of the tasks weigh 125, 53, 64, 826, 444 and 53 g; the cup is taken by its wall, which is 1 mm thick."""
