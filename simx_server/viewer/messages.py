"""The types of the feed's answers to the web viewer. Metres, radians, seconds, world frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypedDict

from simx_client.protocol.reports import Metrics

ADD_ON = "simxView"

LOOK, SURVEY, ONE_PASS, SPEED = "look", "survey", "onePass", "speed"
KEEP, PAST, GO_ON = "keepPast", "past", "goOn"
READS = frozenset({LOOK, SURVEY, KEEP, PAST})
"""Functions that change nothing in the simulation."""

OWN_NAME = "simx-page"
"""Prefix of the names of the viewer's own clients."""

State = Literal["stopped", "running", "paused"]


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
    passes: int
    scene: str
    selection: list[int]


class PastCall(TypedDict):
    """A call of a client in a past simulation step."""

    client: str
    call: str
    """Function and arguments as they are written in a program, shortened."""

    results: str
    """What came back; the reason of a failed call; empty: no result, or none yet."""

    has_failed: bool
    only_reads: bool


class Past(TypedDict):
    """The world after a past simulation step."""

    look: Look
    """`running`, `time` and `passes` are those of the past; the selection is the present one."""

    call_before: int
    """The last step before this one with a call that changes something; -1: none."""

    call_after: int
    calls: list[PastCall]
    """Those after the step before, until the end of this one, in order."""

    calls_left_out: int
    signals: dict[str, int | float | str]
    joints: dict[int, float]
    """Positions by handle, of joints with one number; rad or m."""


class Kept(TypedDict):
    """What is kept of the present run, or of the last one."""

    now: tuple[State, float, int]
    """The present state, time and number of steps."""

    is_on: bool
    first: int
    last: int
    """Steps; -1: none is kept."""

    version: int
    """Changes when later steps than the first ones are gone."""

    seconds: float
    size: int
    """Bytes."""


class GoneOn(TypedDict):
    step: int
    time: float
    restarted: list[str]
    """Scripts that have started again, without the values of their variables."""


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
    """As `user_interface.UserInterface.describe`, the end of growing texts."""

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
    workspace: str
