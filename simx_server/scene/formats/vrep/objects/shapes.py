"""Shapes and their leaves, textures, surfaces, and point clouds."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from simx_server.scene.poses.poses import IDENTITY, Pose

from .common import EngineValues, Material, VrepObject


@dataclass(kw_only=True)
class TextureUse:
    """How a leaf is textured."""

    texture: int
    """Id of a texture, or handle of a vision sensor whose image is the texture."""
    mode: int = 0
    """Projection: 0 plane, 1 cylinder, 2 sphere, 3 cube."""
    scale: tuple[float, float] = (1.0, 1.0)
    """Size of a repetition along u and v in metres."""
    frame: Pose = IDENTITY
    """Frame of the projection, in the leaf's shape."""
    coordinates: NDArray[np.float32] | None = None
    """Fixed coordinates, (corners of triangles, 2); None with a projection."""
    flags: int = 0


class Primitive(IntEnum):
    """Forms of a leaf, with the file's numbers."""

    MESH = 0
    PLANE = 1
    DISC = 2
    CUBOID = 3
    SPHEROID = 4
    CYLINDER = 5
    CONE = 6
    HEIGHT_FIELD = 7
    CAPSULE = 8


@dataclass(kw_only=True)
class Leaf:
    """One piece of a shape's geometry. Points in the shape's frame are `pose` applied to the points here."""

    pose: Pose = IDENTITY
    primitive: Primitive = Primitive.MESH
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Full size in x, y, z of a primitive: diameter, diameter, height of a cylinder."""
    vertices: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    """(vertices, 3) in the leaf's frame, for primitives too."""
    triangles: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 3), np.int32))
    """(triangles, 3), indices into `vertices`."""
    normals: NDArray[np.float32] | None = None
    """(triangles, 3, 3): a normal per corner."""
    material: Material = field(default_factory=Material)
    texture: TextureUse | None = None
    is_wireframe: bool = False
    """Drawn as lines."""
    culls_backfaces: bool = False
    is_convex: bool = False
    shading_angle: float = 0.0
    heights: NDArray[np.float64] | None = None
    """(rows, columns) of a height field."""


@dataclass(kw_only=True)
class Surface:
    """Parameters of contacts, per engine."""

    name: str = ""
    engines: EngineValues = field(default_factory=EngineValues)


@dataclass(kw_only=True)
class Shape(VrepObject):
    """A shape: one or several leaves."""

    leaves: list[Leaf] = field(default_factory=list[Leaf])
    mass: float = 0.0
    inertia_frame: Pose = IDENTITY
    """Centre of mass and principal axes, in the shape's frame."""
    inertia: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Principal moments divided by the mass, m^2."""
    is_dynamic: bool = False
    is_respondable: bool = False
    is_asleep: bool = False
    mask: int = 0xFFFF
    """Respondable mask: local byte low, global byte high."""
    first_velocity: tuple[float, ...] = (0.0,) * 6
    """Linear and angular."""
    is_convex: bool = False
    is_grouped: bool = False
    """Whether the shape is a group (compound) of leaves."""
    surface: Surface | None = None


@dataclass(kw_only=True)
class Texture:
    """A texture; row 0 of the pixels lies at v = 0."""

    id: int
    pixels: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((1, 1, 3), np.uint8))
    """(height, width, 3 or 4)."""


@dataclass(kw_only=True)
class PointCloud(VrepObject):
    """A point cloud, or an octree: points with colours."""

    is_octree: bool = False
    size: float = 0.01
    """Edge of an octree's cells, or largest edge of the cells in which a point cloud keeps its points, m."""
    points: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    """(points, 3) in the object's frame; of an octree, the middles of its cells."""
    colors: NDArray[np.uint8] | None = None
    """(points, 3)."""
    tags: NDArray[np.uint32] | None = None
    """(points,): a number of each cell of an octree, set by its author."""
    bounds: tuple[float, ...] = ()
