"""Compound shapes: grouping, ungrouping, division, convex parts."""

from __future__ import annotations

from simx_server.editing.compounds import decomposing, grouping, relocating, ungrouping
from simx_server.errors import CommandError
from simx_server.handlers.objects import shape_boxes
from simx_server.scene.objects import ObjectKind
from simx_server.scene.poses.frames import get_pose, wxyz_from_xyzw
from simx_server.scene.poses.poses import NO_TURN, Pose, conjugate, multiply
from simx_server.sim_api.base import ApiPart

_MORPH = 1
"""Bit of the options of sim.convexDecompose."""


class CompoundFunctions(ApiPart, effect="changes"):
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
        stay. Seven zeros mean the middle and the directions of the bounding box. Links of a mechanism are an error.
        """
        handle = self._self(shape)
        if len(pose) < 7:
            raise CommandError(f"a pose has 7 numbers, not {len(pose)}")
        if not any(pose[:7]):
            turn = multiply(get_pose(self._sim, handle)[1], shape_boxes.turn_of(self._world, handle))
            self._relocate(handle, relocating.middle(self._world, handle, turn))
        else:
            self._relocate(handle, ((pose[0], pose[1], pose[2]), wxyz_from_xyzw(pose[3:7])))
        return 1

    def _relocate(self, handle: int, pose: Pose) -> None:
        """Move the frame of a shape; its bounding box lies along the new one."""
        relocating.relocate(self._world, handle, pose)
        shape_boxes.set_turn(self._world, handle, NO_TURN)

    def reorientShapeBoundingBox(self, shape: int, relative_to: int, _reserved: int = 0) -> int:
        """Turn the frame of a shape like the world (-1) or another object, into the middle of its bounding box;
        return 1. Surface and children stay. Links of a mechanism are an error. V-REP 3's form.
        """
        handle = self._self(shape)
        turn = NO_TURN if relative_to == -1 else get_pose(self._sim, self._self(relative_to))[1]
        self._relocate(handle, relocating.middle(self._world, handle, turn))
        return 1

    def alignShapeBB(self, shape: int, pose: list[float]) -> bool:
        """Turn the bounding box of a shape, which sim.getShapeBB returns, to the directions of a pose in the world;
        seven zeros turn it to the smallest box about the surface. The frame stays. Return false for a primitive,
        whose box cannot be turned.
        """
        handle = self._self(shape)
        self._sim.scene.get_kind(handle, ObjectKind.SHAPE)
        if len(pose) < 7:
            raise CommandError(f"a pose has 7 numbers, not {len(pose)}")
        if shape_boxes.is_primitive(self._world, handle):
            return False
        if any(pose[3:7]):
            own = conjugate(get_pose(self._sim, handle)[1])
            turn = multiply(own, wxyz_from_xyzw(pose[3:7]))
        else:
            with self._at_no_cost():
                turn = shape_boxes.natural_turn(self._world, handle)
        shape_boxes.set_turn(self._world, handle, turn)
        return True

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
