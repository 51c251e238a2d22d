"""Compound shapes: grouping, ungrouping, division, convex parts."""

from __future__ import annotations

from simx_server.editing.compounds import decomposing, grouping, relocating, ungrouping
from simx_server.errors import CommandError
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import get_pose, wxyz_from_xyzw
from simx_server.scene.poses.poses import NO_TURN
from simx_server.sim_api.base import ApiPart

_MORPH = 1
"""Bit of the options of sim.convexDecompose."""

_STRAIGHT = 1e-6
"""Largest part of a quaternion that turns nothing."""


class CompoundFunctions(ApiPart):
    """Functions for compound shapes. The stop undoes a change during a run."""

    def groupShapes(self, shapes: list[int], _merge: bool = False) -> int:
        """Make a compound of shapes and return its handle, that of the last one, which keeps its frame and parent. It
        has the masses and the children of all; the others are removed.

        Partly: shapes that are merged into one mesh keep their parts too.
        """
        return grouping.group(self._world, [self._self(shape) for shape in shapes])

    def ungroupShape(self, shape: int) -> list[int]:
        """Make a shape of each part of a compound; return their handles, the shape itself first. The parts of a free
        shape share its mass by their volumes.
        """
        return ungrouping.ungroup(self._world, self._self(shape))

    ungroupShapes = ungroupShape

    def divideShape(self, shape: int) -> list[int]:
        """Make a static shape of each unconnected part of a surface, in place of the shape; return their handles."""
        return ungrouping.divide(self._world, self._self(shape))

    def relocateShapeFrame(self, shape: int, pose: list[float]) -> int:
        """Move the frame of a shape to a pose in the world, x, y, z and quaternion; return 1. Surface and children
        stay. Seven zeros mean the middle of the bounding box. Links of a mechanism are an error.
        """
        handle = self._self(shape)
        if len(pose) < 7:
            raise CommandError(f"a pose has 7 numbers, not {len(pose)}")
        if not any(pose[:7]):
            relocating.relocate(self._world, handle, relocating.middle(self._world, handle))
        else:
            relocating.relocate(self._world, handle, ((pose[0], pose[1], pose[2]), wxyz_from_xyzw(pose[3:7])))
        return 1

    def reorientShapeBoundingBox(self, shape: int, relative_to: int, _reserved: int = 0) -> int:
        """Turn the frame of a shape like the world (-1) or another object, into the middle of its bounding box;
        return 1. Surface and children stay. Links of a mechanism are an error. V-REP 3's form.
        """
        handle = self._self(shape)
        turn = NO_TURN if relative_to == -1 else get_pose(self._sim, self._self(relative_to))[1]
        relocating.relocate(self._world, handle, relocating.middle(self._world, handle, turn))
        return 1

    def alignShapeBB(self, shape: int, pose: list[float]) -> int:
        """Return 1 for the directions of the shape's frame, along which a bounding box lies.

        Partly: other directions are an error; sim.relocateShapeFrame turns the frame.
        """
        self._sim.scene.get_kind(self._self(shape), ObjectKind.SHAPE)
        if len(pose) < 7:
            raise CommandError(f"a pose has 7 numbers, not {len(pose)}")
        if any(abs(value) > _STRAIGHT for value in pose[3:6]) or abs(pose[6]) <= _STRAIGHT:
            raise CommandError(
                "a bounding box lies along the axes of its shape's frame; turn that with sim.relocateShapeFrame"
            )
        return 1

    def convexDecompose(
        self,
        shape: int,
        options: int = 0,
        _int_params: list[int] | None = None,
        _float_params: list[float] | None = None,
    ) -> int:
        """Make a shape of convex parts that fill a closed shape; return its handle. Bit 0 of `options`: the shape
        itself gets these parts. An error without the library of the extra `convex`.

        Partly: the parameters of V-REP's libraries are ignored; CoACD has its own.
        """
        with self._at_no_cost():
            return decomposing.convex_shape(self._world, self._self(shape), morph=bool(options & _MORPH))
