"""Objects of API 2 in Python, for programs outside and scripts inside: members become calls of the server.

Reading a member asks for its type first, and keeps the answer for all objects of the class: a method becomes a
function, a group becomes another object, everything else is read. The standard library suffices, since scripts run this
text in their own process.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any, ClassVar

HANDLE_SELF, HANDLE_SCENE, HANDLE_APP = -4, -12, -13

GROUP, METHOD = 24, 240
"""sim.propertytype_group, sim.propertytype_method."""

REMOVABLE = 4
"""sim.propertyinfo_removable."""

FREE = ("customData", "signal", "refs", "origRefs", "namedParam")
"""Groups to which programs add properties, whose type follows the value."""

_KNOWN: dict[str, dict[str, int]] = {}
"""Types of members by class and name, of those that cannot be removed."""


class Object:
    """An object of the server, by its handle."""

    _callMethod: ClassVar[Any] = None
    """Calls a method: the handle, the name, the arguments. Programs set it; without one `connector` is called."""

    connector: ClassVar[Any] = None
    """Returns such a function when the first call has none; None: programs must set it."""

    def __init__(self, handle: int | Object) -> None:
        """Refer to an object.

        Args:
            handle: of the object, or another reference to it.

        Raises:
            TypeError: neither of both.
        """
        number: Any = handle.handle if isinstance(handle, Object) else handle
        if isinstance(number, bool) or not isinstance(number, int):
            raise TypeError(f"an object is made of a handle, not of {number!r}")
        vars(self).update(_handle=number, _type="")

    @property
    def handle(self) -> int:
        """Return the handle; that of `sim.self` is known from the first call on."""
        if vars(self)["_handle"] == HANDLE_SELF:
            vars(self)["_handle"] = self._call(HANDLE_SELF, "getLongProperty", "handle")
        return vars(self)["_handle"]

    @property
    def objectType(self) -> str:
        """Return the class, such as shape: the name that the first clients gave it."""
        return _type_of(self)

    def callMethod(self, name: str, *arguments: Any) -> Any:
        """Call a method: no result is (), one is the value, several are a tuple."""
        return self._call(self.handle, name, *arguments)

    @staticmethod
    def _call(handle: int, name: str, *arguments: Any) -> Any:
        if Object._callMethod is None:
            if Object.connector is None:
                raise RuntimeError("set sim.Object._callMethod to the function call of a connection first")
            Object._callMethod = Object.connector()
        return Object._callMethod(handle, name, *arguments)

    def isValid(self) -> bool:
        """Return whether the object exists."""
        return bool(self.callMethod("isValid"))

    def getPropertyInfo(self, name: str, options: dict[str, Any] | None = None) -> Any:
        """Return type, flags and description; three times None for an unknown name with the option `noError`."""
        return self.callMethod("getPropertyInfo", name, options or {})

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _member(self, name)

    def __setattr__(self, name: str, value: Any) -> None:
        _assign(self, name, value)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Object) and other.handle == self.handle

    def __hash__(self) -> int:
        return hash(self.handle)

    def __repr__(self) -> str:
        return f"sim.Object({self.handle})"

    def __dir__(self) -> list[str]:
        first = (name.partition(".")[0] for name in _names(self, ""))
        return sorted({*super().__dir__(), *first})


class PropertyGroup:
    """Properties whose names start alike: `scene.simulation`, `cube.customData`."""

    _object: Object
    _prefix: str

    def __init__(self, owner: Object, prefix: str = "") -> None:
        """Refer to a group. `prefix`: without the dot at its end."""
        vars(self).update(_object=owner, _prefix=prefix)

    def _full(self, name: str) -> str:
        return f"{self._prefix}.{name}" if self._prefix else name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _member(self._object, self._full(name))

    def __setattr__(self, name: str, value: Any) -> None:
        _assign(self._object, self._full(name), value)

    def __delattr__(self, name: str) -> None:
        self._object.callMethod("removeProperty", self._full(name))

    def __iter__(self) -> Iterator[str]:
        prefix = self._full("")
        return (name.removeprefix(prefix) for name in _names(self._object, prefix))

    def __dir__(self) -> list[str]:
        return sorted(set(self))

    def __repr__(self) -> str:
        return f"sim.PropertyGroup({self._object!r}, prefix={self._prefix!r})"


def _type_of(owner: Object) -> str:
    if not vars(owner)["_type"]:
        vars(owner)["_type"] = owner.callMethod("getStringProperty", "objectType")
    return vars(owner)["_type"]


def _kind(owner: Object, name: str) -> int | None:
    """Return the type of a member; None: there is none."""
    known = _KNOWN.setdefault(_type_of(owner), {})
    if name not in known:
        kind, flags, _ = owner.getPropertyInfo(name, {"noError": True})
        if kind is None or flags & REMOVABLE:
            return kind
        known[name] = kind
    return known[name]


def _member(owner: Object, name: str) -> Any:
    kind = _kind(owner, name)
    if kind is None:
        raise AttributeError(f"{owner!r} ({_type_of(owner)}) has no attribute '{name}'")
    if kind == METHOD:
        return partial(owner.callMethod, name)
    if kind == GROUP:
        return PropertyGroup(owner, name)
    return owner.callMethod("getProperty", name, {"type": kind})


def _assign(owner: Object, name: str, value: Any) -> None:
    if name.partition(".")[0] in FREE:
        owner.callMethod("setProperty", name, value, {})
    else:
        kind = _kind(owner, name)
        owner.callMethod("setProperty", name, value, {} if kind is None else {"type": kind})


def _names(owner: Object, prefix: str) -> Iterator[str]:
    for place in range(100_000):
        name, _ = owner.callMethod("getPropertyName", place, {"prefix": prefix})
        if name is None:
            return
        yield name


def call_by(function: Any) -> None:
    """Call methods of all objects by a function of the handle, the name and the arguments."""
    Object._callMethod = staticmethod(function)  # pyright: ignore[reportPrivateUsage]


def connect_by(connector: Any) -> None:
    """Get that function from `connector` when the first call has none."""
    Object.connector = staticmethod(connector)
