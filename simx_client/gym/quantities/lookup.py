"""Find the objects of names, and the quantities that these objects have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, TypeVar

from simx_client.client.servers import Servers
from simx_client.protocol import constants as c

from .names import WORLD, Name, Subject
from .readable import KINDS, OBJECT, SIGNAL

_ALL, _NAMES, _TYPES = c.sim_appobj_object_type, 0, 1


class Quantity(Protocol):
    """The common fields of `Readable` and `Writable`."""

    @property
    def kind(self) -> str: ...
    @property
    def attribute(self) -> str: ...
    @property
    def meaning(self) -> str: ...
    @property
    def has_frame(self) -> bool: ...


Q = TypeVar("Q", bound=Quantity)

_A = {OBJECT: "an"}


class Objects:
    """Handles of the objects that names refer to, in each simulation."""

    def __init__(self, servers: Servers, names: Iterable[Name]) -> None:
        """Look up all objects with two messages per simulation.

        Raises:
            CallsFailed: an object does not exist; the text contains the nearest names.
        """
        names = list(names)
        objects = dict.fromkeys(name.object for name in names if not is_signal(name))
        frames = dict.fromkeys(name.frame for name in names if name.frame is not None)
        # The handle of a camera prepares its images, which takes time and memory: a frame needs none.
        listed = servers.each(
            lambda calls, _: (
                calls.simxGetObjectGroupData(_ALL, _NAMES),
                calls.simxGetObjectGroupData(_ALL, _TYPES),
            )
        )
        by_name = [dict(zip(answer.value[3], answer.value[0], strict=True)) for answer, _ in listed]
        is_plain = {frame: all(frame in known for known in by_name) for frame in frames}
        wanted = list(dict.fromkeys([*objects, *(frame for frame in frames if not is_plain[frame])]))
        found = servers.each(lambda calls, _: [calls.simxGetObjectHandle(each) for each in wanted])
        self._handles = [
            {frame: known[frame] for frame in frames if is_plain[frame]}
            | dict(zip(wanted, (answer.value for answer in handles), strict=True))
            for known, handles in zip(by_name, found, strict=True)
        ]
        handles, types, _, _ = listed[0][1].value
        self._types: dict[int, int] = dict(zip(handles, types, strict=True))

    def kind_of(self, name: Name) -> str:
        """Return the kind of the object of a name."""
        if is_signal(name):
            return SIGNAL
        return KINDS.get(self._types[self._handles[0][name.object]], OBJECT)

    def subjects(self, name: Name) -> list[Subject]:
        """Return the object of a name in each simulation."""
        return [
            Subject(
                name.object,
                WORLD if is_signal(name) else handles[name.object],
                WORLD if name.frame is None else handles[name.frame],
            )
            for handles in self._handles
        ]

    def quantity(self, name: Name, table: Sequence[Q], verb: str) -> Q:
        """Return the entry of a table for a name.

        Args:
            verb: "observed" or "set", for the message.

        Raises:
            ValueError: the object has no such quantity; the text lists the ones that it has.
        """
        kind = self.kind_of(name)
        has = {each.attribute: each for each in table if each.kind == OBJECT and kind != SIGNAL}
        has |= {each.attribute: each for each in table if each.kind == kind}
        entry = has.get(name.attribute)
        if entry is None:
            raise ValueError(
                f"{name.text!r}: {name.object!r} is {_A.get(kind, 'a')} {kind}; {', '.join(has)} of it can be {verb}, "
                f"not {name.attribute!r}"
            )
        if name.frame is not None and not entry.has_frame:
            raise ValueError(f"{name.text!r}: {name.attribute!r} of a {kind} does not depend on a frame")
        return entry


def is_signal(name: Name) -> bool:
    """Return whether a name is that of a signal."""
    return name.attribute.endswith("_signal")
