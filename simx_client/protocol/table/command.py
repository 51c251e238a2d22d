"""The entries of the table: functions with their arguments, results and effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from enum import Enum
from functools import cached_property
from typing import Any

from ..kinds import Kind
from ..python.light_dataclass import dataclass
from .meanings import Meaning


class Place(Enum):
    """Where a function is executed."""

    REMOTE = "remote"
    """In the server, in any operation mode."""

    WAITING = "waiting"
    """In the server, always blocking: the function takes no operation mode."""

    LOCAL = "local"
    """In the client, written by hand in ``simx_client/legacy/local.py``; it may call remote ones."""

    CARRIED = "carried"
    """In the server, on behalf of a function of the client; without a public name and a line in the listing."""


class Effect(Enum):
    """The effect of a function on the simulator. It decides who may call the function, and what the call waits for."""

    NOTHING = "nothing"
    """The server takes no part; the function works on the client's own data."""

    READS = "reads"
    """Changes nothing that another client could notice. Clients of the viewer role may call only these."""

    TAKES = "takes"
    """Reads something once: other clients cannot read it again."""

    CHANGES = "changes"
    """Changes the state of objects, signals, files or the user interface."""

    EDITS = "edits"
    """Changes the content of the scene, or settings of objects and of the simulator. Waits while a script runs."""

    CONTROLS = "controls"
    """Starts, pauses or stops the simulation, or its stepped mode. Waits while a script runs."""

    STEPS = "steps"
    """Makes one simulation step, then answers. Waits while a script runs."""

    RUNS_CODE = "runs code"
    """Runs a script of the scene. Waits while another one runs."""


@dataclass(frozen=True, slots=True)
class Value:
    """One argument or result: its legacy name and its meaning."""

    name: str
    meaning: Meaning

    @property
    def kind(self) -> Kind:
        """Return the kind: the valid values and their encoding."""
        return self.meaning.kind


@dataclass(frozen=True, eq=False, kw_only=True)
class Command:
    """One entry of the table.

    ``clientID`` comes first and ``operationMode`` last in every remote function, so neither is written.
    """

    name: str
    takes: dict[str, Meaning] = field(default_factory=dict[str, Meaning])
    """The arguments in order, by the names that the original binding gives them."""

    gives: dict[str, Meaning] = field(default_factory=dict[str, Meaning])
    """The results in order, without the return code."""

    doc: str
    """The purpose of the function, in one sentence."""

    effect: Effect
    place: Place = Place.REMOTE
    key: tuple[str, ...] = ()
    """The arguments that make two calls *the same command*: they share one inbox entry and one stream."""

    aliases: tuple[str, ...] = ()
    """Other names of the function."""

    legacy_id: int | None = None
    """Its number in the original's protocol; None: the original has no such command."""

    twin: str = ""
    """The function of the regular API that does the same in a script."""

    remark: str = ""
    """More for the reference page, in place of the handler's docstring."""

    makes_image: bool = False
    """The server renders an image for the answer."""

    adds_objects: bool = False
    """Can add objects to the scene."""

    loads_file: bool = False
    """Bit 0 of its second argument: the file named by the first one is on the client's side."""

    keeps_every_call: bool = False
    """Calls with equal keys are all executed, even when they wait in one paused batch."""

    takes_what_it_reads: bool = False
    """Each successful read empties the inbox; unread data is concatenated, none is lost."""

    never_blocking: bool = False
    """Blocking mode is refused with the illegal-mode code."""

    stream_ends_with_hit: bool = False
    """Its stream ends automatically with the first hit; reading in buffer mode removes that value."""

    no_hit: int | None = None
    """First result of a success without a hit; None: every success is a hit."""

    @cached_property
    def arguments(self) -> tuple[Value, ...]:
        return tuple(Value(name, meaning) for name, meaning in self.takes.items())

    @cached_property
    def results(self) -> tuple[Value, ...]:
        return tuple(Value(name, meaning) for name, meaning in self.gives.items())

    @cached_property
    def parameters(self) -> tuple[str, ...]:
        """Return the Python parameter names in order, spelled as in the original binding."""
        client = () if self.place is Place.LOCAL else ("clientID",)
        mode = ("operationMode",) if self.place is Place.REMOTE else ()
        return (*client, *self.takes, *mode)

    @cached_property
    def gives_image(self) -> bool:
        """Return whether a result is an image: its streams are sent alone, and only the newest image."""
        return any(meaning.kind.is_image for meaning in self.gives.values())

    @cached_property
    def answers_soon(self) -> bool:
        """Return whether the answer comes without rendering and without a simulation step."""
        return not self.makes_image and self.effect is not Effect.STEPS

    @cached_property
    def only_reads(self) -> bool:
        """Return whether it changes nothing that another client could notice, so that viewers may call it."""
        return self.effect is Effect.READS

    @cached_property
    def waits_for_scripts(self) -> bool:
        """Return whether it waits while a script runs. Others can be executed between two calls of the script."""
        return self.effect in (Effect.EDITS, Effect.CONTROLS, Effect.STEPS, Effect.RUNS_CODE)

    def is_hit(self, values: Sequence[Any]) -> bool:
        """Return whether a success with these results ends a stream of this command."""
        return self.stream_ends_with_hit and (self.no_hit is None or values[:1] != [self.no_hit])

    @cached_property
    def names(self) -> tuple[str, ...]:
        return (self.name, *self.aliases)

    @cached_property
    def checks(self) -> tuple[Callable[[Any], Any], ...]:
        """Return the check of each argument, for the server."""
        return tuple(meaning.kind.check for meaning in self.takes.values())

    @cached_property
    def key_positions(self) -> tuple[int, ...]:
        order = list(self.takes)
        return tuple(order.index(name) for name in self.key)
