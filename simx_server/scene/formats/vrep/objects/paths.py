"""Paths and graphs of V-REP 3."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from simx_server.scene.poses.poses import Pose

from .common import Color, Material, VrepObject


@dataclass(kw_only=True)
class PathPoint:
    """A control point of a path, in the path's frame."""

    pose: Pose
    bezier: tuple[float, float] = (1.0, 1.0)
    """Interpolation factors before and after the point."""
    bezier_points: int = 1
    virtual_distance: float = 0.0
    """Length of the path on the spot, m."""
    velocity: float = 1.0
    """Share of the nominal velocity."""
    flags: int = 0
    channels: tuple[float, ...] = (0.0,) * 4


@dataclass(kw_only=True)
class Path(VrepObject):
    """A path object of V-REP 3."""

    points: list[PathPoint] = field(default_factory=list[PathPoint])
    is_closed: bool = False
    size: float = 0.01
    """Of the marks of its points."""
    attributes: int = 0
    """`sim_pathproperty_*` bits: 1 line shown, 4 closed, 8 orientation from the course, 0x40 flat, 0x800 x kept up."""
    color: Material = field(default_factory=Material)
    """Of the line."""
    is_shaped: bool = False
    """Whether the path is drawn as a body too: `section` along the path. Vision sensors may see that."""
    section: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    """Corners of the cross-section in m, in the x-y plane of a frame whose z axis is the path's direction."""
    section_color: Material = field(default_factory=Material)
    section_spacing: float = 0.0
    """Least distance between two cross-sections, m."""
    position: float = 0.0
    """Metres along the path."""
    target_velocity: float = 0.0
    """Nominal velocity of the position, m/s."""
    length_method: int = 5
    """How lengths follow from distances and angles: `sim_distcalcmethod_*`."""
    angle_to_length: float = 0.1 / (math.pi / 2)
    """Metres per radian."""
    virtual_to_length: float = 1.0
    """Metres per unit of the points' virtual distance."""


@dataclass(kw_only=True)
class GraphStream:
    """A recorded stream of a graph."""

    name: str
    id: int
    kind: int
    """1, 2, 3: x, y, z of an object; 501, 502, 503: of the point that a sensor detects; 2102: length of a distance
    object. -1 since CoppeliaSim 4: a script added the stream, and adds it again when it starts.
    """
    object: int = -1
    color: Color = (1.0, 0.0, 0.0)


@dataclass(kw_only=True)
class GraphCurve:
    """Two or three streams of a graph against each other."""

    name: str
    streams: tuple[int, ...]
    """Ids of the streams."""


@dataclass(kw_only=True)
class Graph(VrepObject):
    """A graph."""

    size: float = 0.1
    capacity: int = 1000
    is_explicit: bool = False
    """Values are recorded only when a script handles the graph."""
    streams: list[GraphStream] = field(default_factory=list[GraphStream])
    curves: list[GraphCurve] = field(default_factory=list[GraphCurve])
