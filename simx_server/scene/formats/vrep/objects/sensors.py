"""Vision sensors, proximity sensors, cameras, lights; other objects without further facts."""

from __future__ import annotations

from dataclasses import dataclass, field

from .common import Color, Material, Volume, VrepObject


@dataclass(kw_only=True)
class Filter:
    """A component of a vision sensor's filter chain."""

    type: int
    enabled: bool = True
    integers: list[int] = field(default_factory=list[int])
    reals: list[float] = field(default_factory=list[float])
    data: bytes = b""


@dataclass(kw_only=True)
class View(VrepObject):
    """Facts that vision sensors and cameras share; both look along z, with y up."""

    is_perspective: bool = True
    angle: float = 1.0
    """Perspective angle of the larger side, rad."""
    orthographic_size: float = 1.0
    """Width of the larger side, m."""
    near: float = 0.01
    far: float = 10.0
    """Near and far clipping plane, m."""


@dataclass(kw_only=True)
class VisionSensor(View):
    """A vision sensor."""

    resolution: tuple[int, int] = (256, 256)
    body: tuple[float, float, float] = (0.01, 0.01, 0.03)
    """Width, height and depth of the body that is drawn."""
    default_color: Color = (0.0, 0.0, 0.0)
    render_mode: int = 0
    entity: int = -1
    """The entity that it renders: -1 all, or the handle of an object or a collection."""
    is_explicit: bool = False
    uses_environment_background: bool = False
    is_external: bool = False
    ignores_rgb: bool = False
    ignores_depth: bool = False
    has_no_statistics: bool = False
    filters: list[Filter] | None = None
    """None for files without filter chains (since CoppeliaSim 4.0)."""


@dataclass(kw_only=True)
class ProximitySensor(VrepObject):
    """A proximity sensor; it looks along z."""

    method: str = "ray"
    """How it detects: the volume's type, or ray with a cone as volume (randomized rays)."""
    volume: Volume = field(default_factory=Volume)
    minimum_distance: float | None = None
    finds_closest: bool = True
    is_explicit: bool = False
    front_faces: bool = True
    back_faces: bool = True
    max_normal_angle: float | None = None
    entity: int = -1
    """The entity that it detects: -1 all, or the handle of an object or a collection."""
    detectable_kind: int = 0
    rays: tuple[int, int] = (1, 1)
    """Of randomized detection: rays of a reading, and how many of them must detect something."""
    size: float = 0.01


@dataclass(kw_only=True)
class Camera(View):
    """A camera of the user interface."""

    near: float = 0.05
    far: float = 30.0
    tracked: int = -1
    size: float = 0.05


@dataclass(kw_only=True)
class Light(VrepObject):
    """A light, which shines along z."""

    size: float = 0.1
    type: int = 3
    """1 omnidirectional, 2 spot, 3 directional."""
    exponent: int = 20
    cutoff: float = 1.0
    """Half angle of a spot, rad."""
    attenuation: tuple[float, float, float] = (1.0, 0.0, 0.0)
    is_on: bool = True
    color: Material = field(default_factory=Material)


@dataclass(kw_only=True)
class OtherObject(VrepObject):
    """An object without further facts: a mill, a mirror, a script object, a marker."""

    kind: str = "other"
    """mill, mirror, script, marker or custom."""
    volume: Volume | None = None
    size: tuple[float, float] = (0.0, 0.0)
