"""Call-backs for objects that are made, copied and removed: ``sysCall_afterCreate`` and its like.

All scripts with the call-back are called, for edits by scripts and by clients. ``sysCall_beforeCopy`` and
``sysCall_beforeDelete`` come before the edit. The others come after it: when the function of the script that edits
returns, or else after the message of the client. Objects that a stop makes and removes are reported too;
those of a scene that is loaded or closed are not.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.simulation.simulation import Simulation

_CREATED, _DELETED = "sysCall_afterCreate", "sysCall_afterDelete"
_BEFORE_DELETE = "sysCall_beforeDelete"
_BEFORE_COPY, _COPIED = "sysCall_beforeCopy", "sysCall_afterCopy"

_FUNCTIONS = (_CREATED, _DELETED, _BEFORE_DELETE, _BEFORE_COPY, _COPIED)

_DEEPEST = 4
"""Most call-backs within each other: a call-back may edit the scene, which causes the next one."""


class ObjectCallBacks:
    """The scripts that have such call-backs."""

    def __init__(
        self, sim: Simulation, call_all: Callable[[str, Any], object], say_once: Callable[[str], None]
    ) -> None:
        """Create an empty list.

        Args:
            call_all: calls a function of all scripts that have it, with one value.
            say_once: prints a line to the status bar once.
        """
        self._sim = sim
        self._call_all = call_all
        self._say_once = say_once
        self._wanted: frozenset[str] = frozenset()
        """Call-backs that some script has."""
        self._known: set[int] = set()
        """Handles of the objects that scripts know of, if a script has a call-back."""
        self._news: list[tuple[str, list[int], bool]] = []
        """Events to report: a function, handles, and whether all objects are concerned."""
        self._depth = 0

    def watch(self, scripts: Collection[Script]) -> None:
        """Update the list of call-backs after scripts have started or ended."""
        wanted = frozenset(name for name in _FUNCTIONS if any(script.has(name) for script in scripts))
        if wanted and not self._wanted:
            self._known = set(self._sim.scene.objects)
        self._wanted = wanted

    def forget(self) -> None:
        """Forget all events when another scene replaces the present one."""
        self._wanted = frozenset()
        self._news.clear()
        self._known.clear()

    def note_changes(self) -> None:
        """Compare the objects with those before an edit, and report them soon."""
        if not self._wanted:
            return
        objects = self._sim.scene.objects
        created = [handle for handle in objects if handle not in self._known]
        deleted = sorted(handle for handle in self._known if handle not in objects)
        self._known = set(objects)
        if deleted:
            self._add(_DELETED, deleted, is_all=not objects)
        if created:
            self._add(_CREATED, created)

    def before_removal(self, handles: Collection[int]) -> None:
        """Call the scripts before objects are removed."""
        if _BEFORE_DELETE in self._wanted:
            self._call(_BEFORE_DELETE, list(handles), len(handles) == len(self._sim.scene.objects))

    def before_copy(self, handles: Collection[int]) -> None:
        """Call the scripts before objects are copied."""
        if _BEFORE_COPY in self._wanted:
            self._call(_BEFORE_COPY, list(handles), False)

    def copied(self, handles: Collection[int]) -> None:
        """Report soon which objects were copied, before their copies are reported."""
        if _COPIED in self._wanted:
            is_first = bool(self._news) and self._news[-1][0] == _CREATED
            self._add(_COPIED, list(handles), at=-1 if is_first else None)

    def tell(self) -> None:
        """Report the events so far. Call it while no edit is in progress."""
        if not self._news:
            return
        news, self._news = self._news, []
        for function, handles, is_all in news:
            self._call(function, handles, is_all)

    def _add(self, function: str, handles: list[int], *, is_all: bool = False, at: int | None = None) -> None:
        if function not in self._wanted:
            return
        if not self._news:
            self._sim.soon(self.tell)
        self._news.insert(len(self._news) if at is None else at, (function, handles, is_all))

    def _call(self, function: str, handles: list[int], is_all: bool) -> None:
        if self._depth >= _DEEPEST:
            self._say_once(
                f"{function} is not called: its scripts edit the scene, and so cause call-backs without end"
            )
            return
        self._depth += 1
        try:
            self._call_all(function, _data(function, handles, is_all))
        finally:
            self._depth -= 1


def _data(function: str, handles: list[int], is_all: bool) -> dict[str, Any]:
    """Return what scripts receive: a list of created objects, else a table with the handles as keys."""
    if function == _CREATED:
        return {"objectHandles": handles}
    known: dict[str, Any] = {"objectHandles": dict.fromkeys(handles, True)}
    if function in (_BEFORE_DELETE, _DELETED):
        known["allObjects"] = is_all
    return known
