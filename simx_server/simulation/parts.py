"""The parts that are told of a simulation's events, in the order in which they were attached."""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable, Collection, Mapping

from .part import Part

logger = logging.getLogger(__name__)

Memories = list[tuple[Part, object]]
"""Parts, and what each of them remembers of a moment."""

_RUN_EVENTS = "run_starting", "run_started", "run_ending", "run_stopping", "run_stopped"


@functools.cache
def _overrides(kind: type[Part], method: str) -> bool:
    """Return whether a kind of part overrides a method."""
    return getattr(kind, method) is not getattr(Part, method)


class Parts:
    """The parts of a simulation. Most of them do nothing at the events of steps and runs, so those are sorted."""

    def __init__(self) -> None:
        self.are_stages_stale = True
        """See `replan`."""
        self._all: list[Part] = []
        self._told_of_steps: tuple[Part, ...] = ()
        self._holding: tuple[Part, ...] = ()
        self._told_of_runs: Mapping[str, tuple[Part, ...]] = dict.fromkeys(_RUN_EVENTS, ())
        self.remembering: tuple[Part, ...] = ()
        """Parts that remember something of a moment, in the order of `remember`."""

    def attach(self, *parts: Part) -> None:
        """Tell these parts of all events from now on, after those attached before; each only once."""
        self._all.extend(part for part in parts if part not in self._all)
        self._sort()

    def detach(self, part: Part) -> None:
        """Tell a part no more."""
        self._all.remove(part)
        self._sort()

    def _sort(self) -> None:
        self._told_of_steps = self._with("step_finished")
        self._holding = self._with("holds_step")
        self.remembering = self._with("remember")
        self._told_of_runs = {event: self._with(event) for event in _RUN_EVENTS}

    def _with(self, method: str) -> tuple[Part, ...]:
        """Return the parts that override a method."""
        return tuple(each for each in self._all if _overrides(type(each), method))

    def tell(self, event: Callable[[Part], object]) -> None:
        """Tell all parts of an event, such as ``lambda part: part.script_stopped(text)``."""
        self.replan()
        for part in tuple(self._all):
            event(part)

    def tell_of_run(self, event: str) -> None:
        """Tell of an event of a run, by the name of the method."""
        self.replan()
        for part in self._told_of_runs[event]:
            getattr(part, event)()

    def tell_of_end(self, before: Callable[[], object]) -> None:
        """Tell that the run ends, after a function. It ends even if this fails; otherwise it could never be ended."""
        told = self._told_of_runs
        for tell in [
            before,
            *(part.run_ending for part in told["run_ending"]),
            *(part.run_stopping for part in told["run_stopping"]),
        ]:
            try:
                tell()
            except Exception:
                logger.exception(
                    "part of what a stop does first has failed; the simulation stops all the same"
                )

    def tell_of_step(self) -> None:
        """Tell of a complete simulation step."""
        for part in self._told_of_steps:
            part.step_finished()

    def holds_step(self) -> bool:
        """Return whether a part wants the next simulation step later (see `Part.holds_step`)."""
        return bool(self._holding) and any(part.holds_step() for part in self._holding)

    def await_steps(self) -> bool:
        """Return whether a part waits for the ends of simulation steps (see `Part.awaits_steps`), or holds them."""
        return any(part.awaits_steps() for part in self._told_of_steps) or self.holds_step()

    def replan(self) -> None:
        """Have the stages of a simulation step listed again: a part has something to do in steps, or has nothing more.

        Events (`tell`) do this as well.
        """
        self.are_stages_stale = True

    def stages_listed(self) -> None:
        """Note that the stages were listed, after all that has called `replan`."""
        self.are_stages_stale = False

    def registered_names(self) -> dict[str, Collection[str]]:
        """Return the names of what exists in the parts beside objects, by its kind of annotation."""
        return {kind: names for part in self._all for kind, names in part.registered_names().items()}

    def remember(self, before: Memories | None) -> Memories:
        """Return what each part needs to go on from here, for `recall`; `before` itself if that is the same."""
        memories = [(part, part.remember()) for part in self.remembering]
        if before is None or len(before) != len(memories):
            return memories
        if before == memories:
            return before
        return [old if old == new else new for old, new in zip(before, memories, strict=True)]

    def recall(self, memories: Memories) -> None:
        """Restore what `remember` returned."""
        self.replan()
        for part, memory in memories:
            part.recall(memory)
