"""Write moments as blocks of bytes, and the parts that moments share once, as sections that they refer to by number.

`recovering.py` reads them.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator
from enum import IntEnum
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco

from simx_server.joints.moments import Moment as JointsMoment
from simx_server.scene.editing.model_state import option_values
from simx_server.scene.objects import Scene

from .journal import Block
from .models import pack_model
from .moments import Moment, Structure
from .packing import pack

if TYPE_CHECKING:
    from simx_server.simulation.saved_state import Snapshot


class Kind(IntEnum):
    """Kinds of blocks."""

    SECTION = 0
    """Part of moments; the number is what they refer to."""

    STOPPED = 1
    """The world while no run exists, or before the run that follows."""

    STEP = 2
    """The world after a step of a run; the number is the step."""


FIELDS = tuple(
    field.name
    for field in dataclasses.fields(Moment)
    if field.name not in {"structure", "joints", "signals", "parts", "size"}
)
FIELDS_OF_JOINTS = tuple(
    field.name
    for field in dataclasses.fields(JointsMoment)
    if field.name not in {"bindings", "values", "weights", "new"}
)
"""Fields of moments that are written with each; the others are sections, or need not be written."""

_fields, _fields_of_joints = attrgetter(*FIELDS), attrgetter(*FIELDS_OF_JOINTS)

OF_STRUCTURE = ("parents", "overrides", "model_properties", "withheld")
"""Fields of a snapshot that are written as they are."""

Run = tuple[str, float, float, bool, dict[str, tuple[str, bool]]]
"""State of the simulation, length of a simulation step and of a physics step, whether a client sent the scene, clients:
id to name and whether it steps the simulation."""


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
    parts: set[int]
    """Identities of the values that its content refers to."""


class Writer:
    """Makes blocks of moments, and remembers which sections were made."""

    def __init__(self, first: First, names_of_parts: tuple[str, ...]) -> None:
        """Make no block yet.

        Args:
            first: the scene that was loaded.
            names_of_parts: of the parts that remember something, for the reader to compare.
        """
        self._first, self._names = first, names_of_parts
        self._known: dict[int, _Section] = {}
        self._count = 0
        self._used: set[int] = set()
        self.unwritten: list[Block] = []
        """Sections that were made since this list was cleared."""

        self.seconds = 0.0
        """Processor time for writing the last model."""

    def block(self, kind: Kind, moment: Moment, run: Run) -> tuple[Block, set[int]]:
        """Return the block of a moment, and the identities of the values in sections that it refers to.

        Raises NotPackable.
        """
        number, joints = self._number, moment.joints
        sections = (
            number(moment.structure, lambda: self._structure(moment.structure)),
            number(moment.signals, lambda: pack(moment.signals)),
            number(joints.bindings, lambda: pack(joints.bindings)),
            number(joints.weights, lambda: pack(joints.weights)),
            number(joints.values, lambda: pack(joints.values)),
            number(self._names, lambda: pack(self._names)),
        )
        memories = [number(memory, partial(pack, memory)) for _, memory in moment.parts]
        content = pack((sections, memories, (*_fields(moment), *_fields_of_joints(joints)), run))
        used, self._used = self._used, set()
        return Block(kind, moment.step, content), used

    def keep_only(self, used: set[int]) -> Iterator[Block]:
        """Forget all sections but these and their parts; return them, to be written again."""
        new = used
        while new := {part for key in new for part in self._known[key].parts} - used:
            used = used | new
        self._known = {key: known for key, known in self._known.items() if key in used}
        return (Block(Kind.SECTION, each.number, each.content) for each in self._known.values())

    def _number(self, value: object, packed: Callable[[], bytes]) -> int:
        """Return the number of a value's section, which is made if there is none."""
        known = self._known.get(id(value))
        if known is None:
            outer, self._used = self._used, set()
            try:
                content = packed()
                parts = self._used
            finally:
                self._used = outer
            known = self._known[id(value)] = _Section(self._count, value, content, parts)
            self.unwritten.append(Block(Kind.SECTION, self._count, content))
            self._count += 1
        self._used.add(id(value))
        return known.number

    def _structure(self, structure: Structure) -> bytes:
        saved, first = structure.snapshot, self._first
        is_first = saved.scene is first.scene
        notes = first.notes if is_first else {}
        values: dict[str, Any] = {
            "model": None if is_first else self._number(saved.scene, lambda: self._model(saved)),
            "arrays": [self._number(content, partial(bytes, content)) for content in saved.arrays],
            "identities": {
                handle: (name, alias, None if annotations is notes.get(handle) else annotations)
                for handle, (name, alias, annotations) in saved.identities.items()
            },
            "annotations": None if is_first and saved.annotations is first.annotations else saved.annotations,
            "options": option_values(saved.options),
            **{name: getattr(saved, name) for name in OF_STRUCTURE},
        }
        return pack(values)

    def _model(self, saved: Snapshot) -> bytes:
        began = time.thread_time()
        try:
            return pack_model(saved.scene, saved.model)
        finally:
            self.seconds = time.thread_time() - began
