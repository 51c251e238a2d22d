"""What the feed tells the page: the maps that travel, as types. Metres, radians, seconds, world frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypedDict

from simx_client.protocol.reports import Metrics

ADD_ON = "simxView"

LOOK, SURVEY, ONE_PASS, SPEED = "look", "survey", "onePass", "speed"

OWN_NAME = "simx-page"
"""Begins the names of the page's own clients."""

State = Literal["stopped", "running", "paused"]


class Look(TypedDict):
    """The scene of one instant."""

    model: int
    """Another number for each model; with `arrays_version` to be given with the next question."""

    arrays_version: int
    binary: bytes | None
    """MuJoCo's model file, compressed by zlib; None when the asker has it."""

    arrays: dict[str, bytes] | None
    """Arrays of the model that differ from `binary`; None: as before."""

    state: bytes
    """float64, of `snapshot.STATE`."""

    running: State
    time: float
    passes: int
    scene: str
    selection: list[int]


class SceneItem(TypedDict):
    """One object; those with a parent come after it."""

    handle: int
    name: str
    path: str
    type: str
    parent: int
    parent_name: str | None
    depth: int
    is_model: bool
    element: str
    """What it is in the model (body, joint, camera, ...), and its `id` there."""

    id: int
    joint: str
    """revolute, prismatic or spherical; empty for what is no joint."""

    resolution: list[int]
    """(columns, rows) of a vision sensor; else empty."""


class JointView(TypedDict):
    position: float | None
    """None for a ball joint, as the target."""

    target: float | None
    mode: int
    """sim_jointmode_."""

    moved_by: str
    """Name of a `joints.servo.Rule`."""

    control: int
    """0 free, 4 velocity, 8 position, 12 spring and damper, as sim_jointintparam_dynctrlmode; -1 for a ball joint."""

    target_velocity: float

    cyclic: bool
    minimum: float
    range: float


class StringView(TypedDict):
    size: int
    beginning: bytes


class Signals(TypedDict):
    integers: dict[str, int]
    floats: dict[str, float]
    strings: dict[str, StringView]
    count: int
    """Of all there are; of thousands only the first are told."""


class StreamView(TypedDict):
    client: str
    command: str
    arguments: str


class Drawing(TypedDict):
    """One drawing object."""

    handle: int
    flags: int
    """Kind and flags as `drawing.py` names them."""

    size: float
    color: tuple[float, float, float]
    points: int
    """Per item; an item begins with their coordinates in the world."""

    items: Sequence[Sequence[float]]


class Survey(TypedDict):
    """All that the panels show."""

    tree_version: int
    tree: list[SceneItem] | None
    """None: as before."""

    drawings_version: int
    drawings: list[Drawing] | None
    joints: dict[int, JointView]
    signals: Signals
    interface: dict[str, Any]
    """As `user_interface.UserInterface.describe`, the end of what grows."""

    messages: int
    """Ever added to the status bar."""

    speed: float | None
    """Times real time; infinity for as fast as it goes; None when there is no pace."""

    time_step: float
    steppers: list[str]
    """Names of the clients that step the simulation."""

    is_waiting: bool
    """Time stands still until one of them triggers a pass."""

    metrics: Metrics
    streams: list[StreamView]
    workspace: str
