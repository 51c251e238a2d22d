"""Entries beside the objects, which name objects by their handles: scripts, collections, groups, pairs, UIs."""

from __future__ import annotations

from dataclasses import dataclass, field

from .common import Color, UserParameter


@dataclass(kw_only=True)
class Script:
    """A script in the file."""

    id: int
    type: int
    """0 main, 1 child, 4 joint control call-back, 5 contact call-back, 6 customization; others are rare."""
    owner: int
    """Handle of the object that it serves, -1 for a main script."""
    object: int = -1
    """Handle of the script object that has it, since CoppeliaSim 4.7; else -1."""
    text: str = ""
    language: str = "lua"
    """lua or python."""
    is_threaded: bool = False
    is_disabled: bool = False
    is_default_main: bool = False
    order: int = 1
    """0 first among siblings, 1 normal, 2 last."""
    traversal: int = 0
    """0 after the scripts below its object, 1 before them, 2 as the next script above."""
    parameters: list[UserParameter] = field(default_factory=list[UserParameter])
    """User parameters of its object, up to V-REP 3.6.1 revision 3."""


@dataclass(kw_only=True)
class Collection:
    """A collection of objects."""

    id: int
    name: str
    overrides: bool = False
    """Its objects are measured and detected whatever their own properties say."""
    entries: list[tuple[int, int, bool]] = field(default_factory=list[tuple[int, int, bool]])
    """Object (-1 for all), kind, additive; their order matters. Kinds: 0 the object, 1 it with all below, 2 all below
    it, 3 it with all above, 4 all above it, 5 all objects.
    """


@dataclass(kw_only=True)
class IkElement:
    """A tip that follows the dummy linked to it."""

    tip: int
    base: int = -1
    constraints: int = 0x1F
    """1 x, 2 y, 4 z, 8 alpha and beta, 16 gamma."""
    precision: tuple[float, float] = (0.0005, 0.01)
    weights: tuple[float, float] = (1.0, 1.0)
    enabled: bool = True


@dataclass(kw_only=True)
class IkGroup:
    """A group of inverse kinematics of V-REP 3."""

    id: int
    name: str
    elements: list[IkElement] = field(default_factory=list[IkElement])
    iterations: int = 3
    damping: float = 0.1
    method: int = 0
    """0 pseudo inverse, 1 damped least squares."""
    is_enabled: bool = True
    is_explicit: bool = False
    ignores_steps: bool = True
    """Whether the greatest steps of the joints in one iteration do not hold."""
    restore: tuple[bool, bool] = (False, False)
    """Whether the joints stay where they are when position, or orientation, is not reached."""
    after: int = -1
    """Id of the group whose failure this one waits for, -1 for none."""


@dataclass(kw_only=True)
class PathPlanning:
    """A path planning task of V-REP 3, which moves a robot so that its start object comes to the goal."""

    id: int
    name: str
    path: int
    """Handle of the path object that a search fills."""
    start: int
    goal: int
    robot: int = -1
    """Object or collection that must not collide."""
    obstacles: int = -1
    """-1: all others."""
    type: int = 0
    """0 x and y, 1 x and gamma, 2 x, y, z, 3 x, y, gamma; others are rare."""
    low: tuple[float, ...] = (-5.0, -5.0, -5.0)
    """Bounds around the start, m."""
    high: tuple[float, ...] = (5.0, 5.0, 5.0)
    seconds: float = 5.0
    """Longest duration of a search."""


@dataclass(kw_only=True)
class MotionPlanning:
    """A motion planning task of V-REP 3, for the joints of a robot."""

    id: int
    name: str
    joints: tuple[int, ...]
    group: int
    """Id of the group of inverse kinematics that brings its tip to a pose."""
    robot: int = -1
    """Object or collection that must not collide with the obstacles; -1: nothing."""
    obstacles: int = -1
    """-1: all others."""
    own: tuple[int, int] = (-1, -1)
    """Two entities of the robot that must not collide with each other; -1 as first: nothing, as second: all."""
    clearances: tuple[float, float] = (0.0, 0.0)
    """Least distances to the obstacles, and of the two entities, m."""
    tip_weights: tuple[float, ...] = (1.0, 1.0, 1.0, 0.1)
    joint_weights: tuple[float, ...] = ()


@dataclass(kw_only=True)
class Pair:
    """A registered collision or distance object."""

    id: int
    name: str
    entity1: int
    entity2: int = -1
    """-1: all others."""
    is_explicit: bool = False
    threshold: float = 0.0


@dataclass(kw_only=True)
class Button:
    """A button, label, edit box or slider of an old custom UI; the numbers are the file's."""

    handle: int
    position: tuple[int, int]
    size: tuple[int, int]
    attributes: int = 0
    label: str = ""
    down_label: str = ""
    slider: int = 0
    """Position of a slider, 0 to 1000."""
    colors: tuple[Color, Color, Color] | None = None
    """Of the background when it is up, when it is down, and of the label."""


@dataclass(kw_only=True)
class OldUI:
    """An old custom UI of V-REP 3, made of buttons (`BBK`)."""

    handle: int
    name: str
    object: int = -1
    """Handle of the object with whose scripts it is associated."""
    size: tuple[int, int] = (1, 1)
    attributes: int = 0
    buttons: list[Button] = field(default_factory=list[Button])
