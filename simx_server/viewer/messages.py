"""The types of the feed's answers to the web viewer. Metres, radians, seconds, world frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypedDict

from simx_client.protocol.add_ons.past import ADD_ON as ADD_ON
from simx_client.protocol.add_ons.past import GO_ON as GO_ON
from simx_client.protocol.add_ons.past import KEEP, KEPT, STEP, Kept, PastStep, State
from simx_client.protocol.reports import Metrics

LOOK, SURVEY, ONE_STEP, SPEED = "look", "survey", "onePass", "speed"
PAST, SENSING, FILES, SAVE = "past", "sensing", "files", "save"
READS = frozenset({LOOK, SURVEY, PAST, SENSING, FILES, KEEP, KEPT, STEP})
"""Functions that change nothing in the simulation."""

OWN_NAME = "simx-page"
"""Prefix of the names of the viewer's own clients."""


class Look(TypedDict):
    """The scene of one instant."""

    model: int
    """A different number for each model; the next call passes it together with `arrays_version`."""

    arrays_version: int
    binary: bytes | None
    """MuJoCo's model file, compressed by zlib; None when the caller has it."""

    arrays: dict[str, bytes] | None
    """Arrays of the model that differ from `binary`; None: as before."""

    state: bytes
    """float64, of `snapshot.STATE`."""

    running: State
    time: float
    steps: int
    scene: str
    selection: list[int]


class Past(TypedDict):
    """The world after a past simulation step."""

    look: Look
    """`running`, `time` and `steps` are those of the past; the selection is the present one."""

    step: PastStep


class ScriptView(TypedDict):
    """A script of the scene."""

    handle: int
    name: str
    """Its kind, object and file."""

    is_running: bool
    is_enabled: bool
    problem: str
    """The error that has stopped it; empty if none has."""

    line: int
    """Where that was; -1: not known."""

    code: str
    """The text of that line."""


class Ray(TypedDict):
    """A reading of a proximity sensor."""

    start: list[float]
    end: list[float]
    """The detected point, or the end of its reach."""

    detects: bool


class Sensing(TypedDict):
    rays: list[Ray]
    forces: list[list[float]]
    """Of each force sensor its position, and the force in newtons: x, y, z each."""


class Files(TypedDict):
    """Names of the shipped files."""

    scenes: list[str]
    models: list[str]


class Saved(TypedDict):
    file: str
    """The file in the workspace; empty where none was named."""
    content: bytes
    """The scene as MuJoCo's archive, where no file was named."""


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
    """The type of its model element (body, joint, camera, ...); `id` is its number there."""

    id: int
    joint: str
    """revolute, prismatic or spherical; empty for objects other than joints."""

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
    """Number of all signals; of thousands only the first are included."""


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
    """Points per item; an item starts with their world coordinates."""

    items: Sequence[Sequence[float]]


class Survey(TypedDict):
    """Everything that the panels show."""

    tree_version: int
    tree: list[SceneItem] | None
    """None: as before."""

    drawings_version: int
    drawings: list[Drawing] | None
    joints: dict[int, JointView]
    signals: Signals
    interface: dict[str, Any]
    """As `user_interface.UserInterface.view`, the end of growing texts."""

    messages: int
    """Messages ever added to the status bar."""

    speed: float | None
    """Times real time; infinity for as fast as possible; None without a pacer."""

    time_step: float
    steppers: list[str]
    """Names of the clients that step the simulation."""

    is_waiting: bool
    """The simulation waits until one of them triggers a step."""

    metrics: Metrics
    streams: list[StreamView]
    past: Kept
    scripts: list[ScriptView]
    workspace: str
