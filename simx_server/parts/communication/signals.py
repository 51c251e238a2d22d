"""Signals: named integers, floats and strings through which clients and scripts exchange values.

A signal set by a client outlives stop, start and another scene, until a client or script clears it; one set by a child
script is cleared with that script, when the run ends. V-REP 4.2 does the same; by the manual of 3.x a start clears all.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING

from simx_server.errors import CommandError

from ..custom_data import APPLICATION

if TYPE_CHECKING:
    from simx_server.simulation.simulation import Simulation

MAX_NAME = 1000
"""Most characters of a signal's name."""


Values = tuple[Mapping[str, int], Mapping[str, float], Mapping[str, bytes]]
"""Integers, floats and strings by name."""


class Signals:
    """Three independent name spaces. A signal is cleared with the `owner` that a setter names; None: it stays."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self.integers: dict[str, int] = {}
        self.floats: dict[str, float] = {}
        self.strings: dict[str, bytes] = {}
        self.typed = TypedSignals(sim)
        self._owned: dict[Hashable, set[tuple[str, str]]] = {}

    def set_integer(self, name: str, value: int, owner: Hashable | None = None) -> None:
        """Set an integer signal. Raises CommandError when there are too many; the same for all kinds."""
        self._check_room(self.integers, name)
        self.integers[name] = int(value)
        self._remember("integers", name, owner)

    def get_integer(self, name: str) -> int | None:
        return self.integers.get(name)

    def clear_integer(self, name: str) -> None:
        """Clear one signal; the empty name clears all of this type (V-REP's rule for all three clears)."""
        _clear(self.integers, name)

    def set_float(self, name: str, value: float, owner: Hashable | None = None) -> None:
        self._check_room(self.floats, name)
        self.floats[name] = float(value)
        self._remember("floats", name, owner)

    def get_float(self, name: str) -> float | None:
        return self.floats.get(name)

    def clear_float(self, name: str) -> None:
        _clear(self.floats, name)

    def set_string(self, name: str, value: bytes, owner: Hashable | None = None) -> None:
        self._check_room(self.strings, name)
        others = sum(map(len, self.strings.values())) - len(self.strings.get(name, b""))
        self._sim.limits.check("signal_bytes", others + len(value), "clear some, or read them")
        self.strings[name] = bytes(value)
        self._remember("strings", name, owner)

    def append_string(self, name: str, value: bytes, owner: Hashable | None = None) -> None:
        """Append to the signal, creating it when there is none."""
        self.set_string(name, self.strings.get(name, b"") + bytes(value), owner)

    def get_string(self, name: str) -> bytes | None:
        return self.strings.get(name)

    def clear_string(self, name: str) -> None:
        _clear(self.strings, name)

    def take_string(self, name: str) -> bytes | None:
        """Return a signal and clear it; None when it does not exist."""
        return self.strings.pop(name, None)

    def clear_owned(self, owner: Hashable) -> None:
        """Clear every signal that was last set with this owner."""
        for table, name in self._owned.pop(owner, ()):
            getattr(self, table).pop(name, None)
        self.typed.clear_owned(owner)

    def remember(self, before: Values | None) -> tuple[Values, int]:
        """Return copies of all signals, or `before` if they are equal, and how many bytes were copied."""
        now: Values = self.integers, self.floats, self.strings
        if before == now:
            assert before is not None
            return before, 0
        strings = 0 if before is not None and before[2] == now[2] else sum(map(len, now[2].values()))
        return (dict(now[0]), dict(now[1]), dict(now[2])), strings + 100 * sum(map(len, now))

    def recall(self, values: Values) -> None:
        """Restore what `remember` returned."""
        self.integers, self.floats, self.strings = dict(values[0]), dict(values[1]), dict(values[2])

    def _check_room(self, table: Mapping[str, object], name: str) -> None:
        if name in table:
            return
        self._sim.limits.check("signals", len(table) + 1, "clear some")
        if len(name) > MAX_NAME:
            raise CommandError(f"a signal's name has at most {MAX_NAME} characters, not {len(name)}")

    def _remember(self, table: str, name: str, owner: Hashable | None) -> None:
        for names in self._owned.values():
            names.discard((table, name))
        if owner is not None:
            self._owned.setdefault(owner, set()).add((table, name))


class TypedSignals:
    """Signals with a type, as CoppeliaSim's properties have them: of an object, the scene or the server.

    Those of objects and of a scene are gone with another scene. A name has one type.
    """

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._scene_id = 0
        self._known: dict[tuple[int, str], tuple[str, bytes, Hashable | None]] = {}

    def set(self, target: int, name: str, kind: str, data: bytes, owner: Hashable | None) -> None:
        """Set a signal of a target: a handle, `sim_handle_scene` or `sim_handle_app`.

        Raises LimitReached, CommandError: too many signals, or too long a name.
        """
        known = self._present()
        key = target, name
        if key not in known:
            self._drop_those_of_removed_objects()
            self._sim.limits.check("signals", len(known) + 1, "clear some")
            if len(name) > MAX_NAME:
                raise CommandError(f"a signal's name has at most {MAX_NAME} characters, not {len(name)}")
        others = sum(len(each) for _, each, _ in known.values()) - len(known.get(key, ("", b"", None))[1])
        self._sim.limits.check("signal_bytes", others + len(data), "clear some")
        known[key] = kind, data, owner

    def get(self, target: int, name: str) -> tuple[str, bytes] | None:
        """Return type and data of a signal, or None."""
        found = self._present().get((target, name))
        return None if found is None else found[:2]

    def clear(self, target: int, name: str) -> bool:
        """Clear a signal; return whether there was one."""
        return self._present().pop((target, name), None) is not None

    def names(self, target: int) -> list[str]:
        """Return the names of all signals of a target."""
        return [name for each, name in self._present() if each == target]

    def clear_owned(self, owner: Hashable) -> None:
        """Clear every signal that was last set with this owner."""
        for key in [key for key, (_, _, setter) in self._known.items() if setter == owner]:
            del self._known[key]

    def _present(self) -> dict[tuple[int, str], tuple[str, bytes, Hashable | None]]:
        """Return the signals, without those of another scene."""
        if self._sim.scene_id != self._scene_id:
            self._scene_id = self._sim.scene_id
            self._known = {key: each for key, each in self._known.items() if key[0] == APPLICATION}
        return self._known

    def _drop_those_of_removed_objects(self) -> None:
        if self._sim.is_running:
            return  # the stop may restore objects that a run removed
        for key in [each for each in self._known if each[0] >= 0 and each[0] not in self._sim.scene.objects]:
            del self._known[key]


def _clear(table: dict[str, int] | dict[str, float] | dict[str, bytes], name: str) -> None:
    if name:
        table.pop(name, None)
    else:
        table.clear()
