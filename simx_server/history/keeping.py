"""Keep the last moments of the world where a crash of this process does not reach them: in a `Journal`.

After each simulation step one moment is written; while the simulation stands still, one after each change. Equal parts
of moments, such as arrays of the model, signals and settings of joints, are written once, as sections that moments
refer to by number. The state before the present run is kept beside them, because the end of the run restores it.
`recovering.py` makes the world again.
"""

from __future__ import annotations

import dataclasses
import logging
import time
from collections.abc import Callable, Iterator
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco

from simx_server.scene.objects import Scene
from simx_server.world.part import Part

from .journal import Block, Journal
from .models import pack_model
from .moments import Moment, Structure, take
from .packing import NotPackable, pack

if TYPE_CHECKING:
    from simx_server.runtime.server_loop import ServerLoop
    from simx_server.world.saved_state import Snapshot

logger = logging.getLogger(__name__)

KEPT = 3
"""Moments of a run that are kept, beside the state before it."""

LEAST = 16 << 20
"""Bytes of the journal from which on it is begun again."""

SHARE = 0.1
"""Most of the time that may go into writing edited models; until one is written, no moments of it are."""


class Kind(IntEnum):
    """Kinds of blocks."""

    SECTION = 0
    """Part of moments; the number is what they refer to."""

    STOPPED = 1
    """The world while no run exists, or before the run that follows."""

    STEP = 2
    """The world after a step of a run; the number is the step."""


@dataclasses.dataclass(frozen=True, slots=True)
class First:
    """The scene as the server has loaded it, which its successor has too."""

    scene: Scene
    model: mujoco.MjModel
    annotations: object
    notes: dict[int, object]
    """Annotations by handle."""

    @classmethod
    def of(cls, scene: Scene, model: mujoco.MjModel) -> First:
        """Note the identity of what need not be written."""
        notes: dict[int, object] = {handle: item.annotations for handle, item in scene.objects.items()}
        return cls(scene, model, scene.annotations, notes)


class _Section(NamedTuple):
    number: int
    value: object
    """Held, so that no other value gets its identity."""

    content: bytes
    parts: frozenset[int]
    """Identities of the values that its content refers to."""


class Sections:
    """What was written of values, by their identity."""

    def __init__(self) -> None:
        self._known: dict[int, _Section] = {}
        self._count = 0
        self._used: set[int] = set()
        self.unwritten: list[Block] = []

    def number(self, value: object, packed: Callable[[], bytes]) -> int:
        """Return the number of a value, and have it written if it is new."""
        known = self._known.get(id(value))
        if known is None:
            outer, self._used = self._used, set()
            try:
                content = packed()
                parts = frozenset(self._used)
            finally:
                self._used = outer
            known = self._known[id(value)] = _Section(self._count, value, content, parts)
            self.unwritten.append(Block(Kind.SECTION, self._count, content))
            self._count += 1
        self._used |= {id(value), *known.parts}
        return known.number

    def take_used(self) -> set[int]:
        """Return the identities of the values that were asked for since the last time."""
        used, self._used = self._used, set()
        return used

    def keep_only(self, used: set[int]) -> Iterator[Block]:
        """Forget all other sections; return these, to be written again."""
        self._known = {key: known for key, known in self._known.items() if key in used}
        return (Block(Kind.SECTION, each.number, each.content) for each in self._known.values())


class Keeper(Part):
    """Writes moments of a server's world into a journal. Physics thread only."""

    def __init__(self, loop: ServerLoop, journal: Journal) -> None:
        """Note the scene, which has just been loaded; `begin` starts to write."""
        self._loop, self._journal = loop, journal
        self._world, self._sim = loop.world, loop.simulation
        self.first = First.of(self._sim.scene, self._sim.model)
        self._sections = Sections()
        self._base: Moment | None = None
        self._last: Moment | None = None
        self._blocks: list[tuple[Block, set[int]]] = []
        """That of the state before the run, and those of the last moments; with the sections that they use."""

        self._turn_at = LEAST
        self._models_due = 0.0
        self._complaint = ""

    def begin(self, base: Moment | None = None) -> None:
        """Replace what the journal has by the present world, and write from now on.

        Args:
            base: of a recovered run, the state before it.
        """
        self._base = self._last = base or take(self._world, None)
        try:
            self._blocks = [self._block(self._base, Kind.STOPPED)]
            if self._sim.is_running:
                self._last = take(self._world, self._base)
                self._blocks.append(self._block(self._last, Kind.STEP))
            self._turn()
        except (NotPackable, OSError) as problem:
            self._complain(str(problem))
        self._sim.attach(self)
        self._loop.watches.append(self.look)

    # --- when to write ---------------------------------------------------------------------------

    def look(self) -> None:
        """Write a moment if the world has changed while no step is due."""
        if not self._loop.is_running_freely:
            self._keep()

    def run_starting(self) -> None:
        self._keep()

    def run_started(self) -> None:
        self._keep()

    def step_finished(self) -> None:
        self._keep()

    def run_stopped(self) -> None:
        self._keep()

    # --- how -------------------------------------------------------------------------------------

    def _keep(self) -> None:
        """Write the present world, unless it is the one that was written last."""
        if self._loop.is_going_back or not self._may_write(self._sim.model):
            return
        moment = take(self._world, self._last)
        try:
            block, used = self._block(moment, Kind.STEP if self._sim.is_running else Kind.STOPPED)
            if self._blocks and block == self._blocks[-1][0]:
                return
            for each in (*self._sections.unwritten, block):
                self._journal.append(each)
            self._sections.unwritten.clear()
            self._note(moment, block, used)
            if self._journal.size > self._turn_at:
                self._turn()
        except (NotPackable, OSError) as problem:
            self._complain(str(problem))

    def _note(self, moment: Moment, block: Block, used: set[int]) -> None:
        self._last = moment
        if block.kind == Kind.STOPPED:
            self._base = moment
            self._blocks.clear()
        elif self._blocks[-1][0][:2] == block[:2]:  # the same step, after further calls
            self._blocks.pop()
        self._blocks.append((block, used))
        if len(self._blocks) > 1 + KEPT:
            del self._blocks[1]

    def _may_write(self, model: mujoco.MjModel) -> bool:
        """Return whether this model is written, or may be now."""
        written = (self.first.model, *(each.model for each in (self._base, self._last) if each is not None))
        return any(model is each for each in written) or time.monotonic() >= self._models_due

    def _turn(self) -> None:
        """Begin the journal again with what is needed."""
        used: set[int] = set().union(*(used for _, used in self._blocks))
        self._journal.begin([*self._sections.keep_only(used), *(block for block, _ in self._blocks)])
        self._sections.unwritten.clear()
        self._turn_at = max(LEAST, 3 * self._journal.size)

    def _complain(self, problem: str) -> None:
        """Log, once, that moments cannot be kept."""
        if problem != self._complaint:
            self._complaint = problem
            logger.warning(
                "the simulation cannot be kept as it is now, so a crash would lose what follows: %s", problem
            )

    def _block(self, moment: Moment, kind: Kind) -> tuple[Block, set[int]]:
        sim, sections = self._sim, self._sections
        joints = moment.joints
        fields = {
            field.name: getattr(moment, field.name)
            for field in dataclasses.fields(moment)
            if field.name not in _SHARED
        }
        content = pack(
            fields
            | {
                "structure": sections.number(moment.structure, lambda: self._structure(moment.structure)),
                "signals": sections.number(moment.signals, lambda: pack(moment.signals)),
                "parts": sections.number(
                    moment.parts, lambda: pack([(type(part).__name__, memory) for part, memory in moment.parts])
                ),
                "bindings": sections.number(joints.bindings, lambda: pack(joints.bindings)),
                "weights": sections.number(joints.weights, lambda: pack(joints.weights)),
                "values": sections.number(joints.values, lambda: pack(joints.values)),
                "joints": {
                    field.name: getattr(joints, field.name)
                    for field in dataclasses.fields(joints)
                    if field.name not in _SHARED
                },
                "run": {
                    "state": sim.state.value,
                    "time_step": sim.time_step,
                    "physics_step": sim.physics_step,
                    "clients": {
                        client: (session.name, session.is_stepping)
                        for client, session in self._loop.sessions.items()
                    },
                },
            }
        )
        return Block(kind, moment.step, content), sections.take_used()

    def _structure(self, structure: Structure) -> bytes:
        saved, first = structure.snapshot, self.first
        is_first = saved.scene is first.scene
        notes = first.notes if is_first else {}
        values: dict[str, Any] = {
            "model": None if is_first else self._model(saved),
            "arrays": [self._sections.number(content, lambda content=content: content) for _, content in saved.arrays],
            "identities": {
                handle: (name, alias, None if annotations is notes.get(handle) else annotations)
                for handle, (name, alias, annotations) in saved.identities.items()
            },
            "annotations": None
            if is_first and saved.annotations is first.annotations
            else saved.annotations,
            **{name: getattr(saved, name) for name in _OF_STRUCTURE},
        }
        return pack(values)

    def _model(self, saved: Snapshot) -> int:
        def packed() -> bytes:
            began = time.monotonic()
            try:
                return pack_model(saved.scene, saved.model)
            finally:
                now = time.monotonic()
                self._models_due = now + (now - began) / SHARE

        return self._sections.number(saved.scene, packed)


_SHARED = {"structure", "joints", "signals", "parts", "size", "bindings", "values", "weights", "new"}
"""Fields of moments that are written otherwise, or not."""

_OF_STRUCTURE = ("options", "parents", "overrides", "model_properties", "withheld")
