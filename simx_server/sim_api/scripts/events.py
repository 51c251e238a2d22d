"""Events: changes of properties, and what scripts tell each other, as CBOR for ``sysCall_event``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

from simx_server.errors import CommandError, UnknownHandle
from simx_server.parts.custom_data import APPLICATION, SCENE
from simx_server.scripting.conversion.signature import to_text
from simx_server.scripting.interpreter import Plain
from simx_server.sim_api.base import ApiPart
from simx_server.sim_api.effects import reads
from simx_server.sim_api.properties import access
from simx_server.sim_api.properties.access import Target
from simx_server.sim_api.values.cbor import encode

if TYPE_CHECKING:
    from simx_server.scripting.script import Script
    from simx_server.world.world import World

_ALL_OBJECTS = -16
"""`sim.handle_sceneobject`: in a filter, every object."""

_NAMES = {SCENE: "sceneChanged", APPLICATION: "appChanged"}
"""Events for changes of the scene and the server themselves."""

_MERGED = 1
"""Bit 0 of the options of sim.pushUserEvent."""

_MOST = 1000
"""Most events that wait for a script."""

_MOST_VALUES = 5_000
"""Most properties that a script watches; each is read in every simulation step."""


class EventFunctions(ApiPart, effect="changes"):
    """Functions for ``sysCall_event(events)``: the script gets a list of events as CBOR after each simulation step, and
    while stopped, if there are any.
    """

    def pushUserEvent(
        self, event: str, handle: int, uid: int, data: dict[str, Any] | list[Any], options: int = 0
    ) -> None:
        """Send an event to all scripts that have ``sysCall_event``. `handle` and `uid` may be -1; bit 0 of `options`:
        it replaces an equal event that still waits.
        """
        known = {
            "event": event,
            **({"handle": handle} if handle != -1 else {}),
            **({"uid": uid} if uid != -1 else {}),
        }
        for script in self._world.scripts.all():
            if script.has("sysCall_event"):
                number = 0 if options & _MERGED else next(self._world.scripts.event_numbers)
                key = (event, handle, uid, number)
                script.events.pop(key, None)
                if len(script.events) >= _MOST:
                    raise CommandError(f"{_MOST} events wait for a script; that is the most")
                script.events[key] = encode({**known, "data": data})
        self._sim.parts.replan()

    def __init__(self, world: World, script: Script) -> None:
        super().__init__(world, script)
        script.watch_all = self._watch_all

    def setEventFilters(self, filters: dict[Any, Any] | list[Any] | None = None) -> None:
        """Choose the properties whose changes this script gets: {[handle] = {names}}; no names mean all properties.
        The handle may be sim.handle_scene, sim.handle_app or sim.handle_sceneobject. No handles mean those of the scene
        and of all objects, as without this call.
        """
        wanted = _wanted(filters)
        watch = _Watch(self._world, self._signal_owner, wanted, self._say_once) if wanted else None
        self._script.changes = self._watch_all() if watch is None else watch.changes
        self._sim.parts.replan()

    def _watch_all(self) -> Callable[[], Sequence[bytes]]:
        """Watch the scene and all objects, and return what gives their changes."""
        wanted: dict[int, Sequence[str]] = {SCENE: (), _ALL_OBJECTS: ()}
        watch = _Watch(self._world, self._signal_owner, wanted, self._say_once, is_lazy=True)
        return watch.changes

    @reads
    def getGenesisEvents(self) -> bytes:
        """Return the events that would make this scene, as CBOR: ``objectAdded`` with the properties of each object,
        and ``sceneChanged`` and ``appChanged`` with those of the scene and the server. Large ones are left out.
        """
        targets = [APPLICATION, SCENE, *self._sim.scene.objects]
        events: list[Plain] = []
        for handle in targets:
            values = _values(Target(self._world, handle, self._signal_owner), ())
            events.append(_event(self._world, _NAMES.get(handle, "objectAdded"), handle, values))
        return encode(events)


class _Watch:
    """Compares properties with those of the last time."""

    def __init__(
        self,
        world: World,
        owner: object,
        wanted: Mapping[int, Sequence[str]],
        say: Callable[[str], None],
        *,
        is_lazy: bool = False,
    ) -> None:
        """Read them for the first time; a lazy one does it when it is asked first.

        Raises:
            CommandError: they are too many.
        """
        self._world, self._owner, self._say = world, owner, say
        self._wanted: Mapping[int, Sequence[str]] = wanted
        self._known: dict[int, dict[str, Any]] | None = None if is_lazy else self._read()

    def changes(self) -> list[bytes]:
        """Return an event for each target with properties that have changed; none any more once they are too many."""
        try:
            now = self._read()
        except CommandError as error:
            self._say(f"sim.setEventFilters: {error}; the script gets no more changes")
            self._wanted = {}
            self._known = {}
            return []
        known, self._known = self._known, now
        found: list[bytes] = []
        if known is None:
            return found
        for handle, values in now.items():
            before = known.get(handle, {})
            changed = {name: value for name, value in values.items() if before.get(name, self) != value}
            if changed:
                name = _NAMES.get(handle, "objectChanged")
                found.append(encode(_event(self._world, name, handle, changed)))
        return found

    def _read(self) -> dict[int, dict[str, Any]]:
        found: dict[int, dict[str, Any]] = {}
        left = _MOST_VALUES
        for handle, names in self._wanted.items():
            for each in self._world.simulation.scene.objects if handle == _ALL_OBJECTS else (handle,):
                try:
                    values = _values(Target(self._world, each, self._owner), names)
                except UnknownHandle:  # removed since
                    continue
                found[each] = {**found.get(each, {}), **values}
                left -= len(values)
                if left < 0:
                    raise CommandError(
                        f"a script watches at most {_MOST_VALUES} properties; name some of them"
                    )
        return found


def _wanted(filters: Mapping[Any, Any] | Sequence[Any] | None) -> dict[int, tuple[str, ...]]:
    """Return the names by handle. Raises CommandError."""
    if isinstance(filters, Sequence):  # a table of Lua with the handles 1, 2, ...
        filters = dict(enumerate(filters, 1))
    found: dict[int, tuple[str, ...]] = {}
    for handle, names in (filters or {}).items():
        if not isinstance(handle, int) or not isinstance(names, (list, dict)):
            raise CommandError(
                "filters are lists of names of properties by handle, such as {[handle] = {'pose'}}"
            )
        listed = cast("list[Any] | dict[Any, Any]", names)
        found[handle] = tuple(to_text(each) for each in listed if isinstance(each, (str, bytes)))
    return found


def _values(target: Target, names: Sequence[str]) -> dict[str, Any]:
    """Return the properties that can be read now, without large ones and images. Raises UnknownHandle."""
    found: dict[str, Any] = {}
    for name in names or access.names(target):
        entry = target.table.get(name)
        if entry is not None and (entry.is_large or entry.waits):
            continue
        try:
            found[name] = access.read(target, name, None)
        except UnknownHandle:
            raise
        except CommandError:  # only to be set, or without a value now
            continue
    return found


def _event(world: World, name: str, handle: int, values: dict[str, Any]) -> dict[str, Any]:
    uid = values.get("objectUid")
    if uid is None and handle in world.simulation.scene.objects:
        uid = access.read(Target(world, handle, None), "objectUid", None)
    return {
        "event": name,
        "handle": handle,
        **({"uid": uid} if uid is not None else {}),
        "seq": next(world.scripts.event_numbers),
        "data": values,
    }
