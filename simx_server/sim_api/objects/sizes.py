"""Sizes of objects: bounding boxes, and scaling."""

from __future__ import annotations

from simx_server.editing import scaling_objects as scaling
from simx_server.errors import CommandError
from simx_server.handlers.objects import bounding_box, shape_boxes
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.values.matrices import as_numbers

_FLAT = 1e-9
"""Metres below which a size cannot be scaled to another one."""


class SizeFunctions(ApiPart, effect="changes"):
    """Functions for sizes: metres along the axes of the object's frame. The stop undoes a change during a run."""

    def scaleObject(self, handle: int, x: float, y: float, z: float, _options: int = 0) -> int:
        """Scale one object about its frame, shapes also by different factors along their axes; return 1.

        Mass and inertia follow the density; ranges of sensors, prismatic joints and forces follow the size. A
        cylinder, cone or capsule follows its x axis where x and y differ.
        """
        scaling.scale_object(self._world, self._self(handle), (x, y, z))
        return 1

    def scaleObjects(self, handles: list[int], factor: float, positions: bool = False) -> int:
        """Scale objects alike along all axes, model bases with all below them; return 1. `positions`: also their
        places in their parents' frames.
        """
        own = [self._self(handle) for handle in handles]
        scaling.scale_objects(self._world, own, factor, positions=positions)
        return 1

    @reads
    def getObjectSizeFactor(self, handle: int) -> float:
        """Return how much the object was scaled since it was made."""
        return scaling.size_factor(self._world, self._self(handle))

    @reads
    def getObjectSizeValues(self, handle: int) -> list[float]:
        """Return how much the object was scaled along each axis since it was made; scripts react to changes of it."""
        return list(scaling.size_values(self._world, self._self(handle)))

    @reads
    def getShapeBB(self, handle: int) -> tuple[list[float], list[float]]:
        """Return the size of a shape's bounding box, and the pose of its centre in the shape's frame."""
        sides, pose = shape_boxes.box(self._world, self._self(handle))
        return sides, as_numbers(pose)

    def setShapeBB(self, handle: int, size: list[float]) -> int:
        """Scale a shape so that its bounding box has this size; return 1. A shape without thickness stays flat. A box
        that was turned (sim.alignShapeBB) can be scaled alike along all axes only.
        """
        if len(size) < 3 or min(size[:3]) < 0:
            raise CommandError(f"the size of a bounding box is three numbers not below 0, not {size}")
        own = self._self(handle)
        present, _ = shape_boxes.box(self._world, own)
        factors = [
            wanted / now if now > _FLAT and wanted > _FLAT else 1.0
            for wanted, now in zip(size[:3], present, strict=True)
        ]
        if shape_boxes.is_turned(self._world, own) and max(factors) > min(factors) * (1 + _FLAT):
            raise CommandError(
                "the bounding box does not lie along the axes of its shape's frame, so its sides can be scaled alike "
                "only; sim.relocateShapeFrame with seven zeros turns the frame"
            )
        scaling.scale_object(self._world, own, factors)
        return 1

    @reads
    def getModelBB(self, handle: int) -> list[float]:
        """Return the size of the bounding box of an object and all below it."""
        least, greatest = bounding_box.of_object(
            self._world, self._self(handle), whole_model=True, with_volumes=False
        )
        return [high - low for low, high in zip(least, greatest, strict=True)]
