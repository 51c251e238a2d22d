"""Classes of a program's own: their properties, which objects of the class start with, and their methods.

A method is a function of the script that made it. It lives there, and ends with it: no code travels.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from simx_server.errors import CommandError
from simx_server.parts.instances import Instance
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.properties.property_types import PropertyType

if TYPE_CHECKING:
    from simx_server.world.world import World

MOST_MEMBERS = 1000
"""Properties of an object, and methods of a class."""

_NAME_BYTES = 100


@dataclass(eq=False)
class CustomObject(Instance):
    """A class, or an object of one."""

    kind = "customObject"

    name: str
    """Of the class: the property `type`."""
    supers: list[str] = field(default_factory=lambda: ["object", "customObject"])
    spaces: list[str] = field(default_factory=list[str])
    """Groups to which programs may add properties."""
    template: CustomObject | None = None
    """The class of an object; None: it is a class."""
    in_app: bool = True
    """Whether it belongs to the server, and not to the scene."""
    values: dict[str, tuple[PropertyType, Any]] = field(default_factory=dict[str, tuple[PropertyType, Any]])
    methods: dict[str, Function] = field(default_factory=dict[str, Function])
    model: bytes = b""
    """Of a class of scene objects: the file of which they are made."""
    is_base: bool = True
    """Of such a class: whether its objects are bases of models."""
    members: set[int] = field(default_factory=set[int])
    """Of such a class: handles of its objects."""

    @property
    def type(self) -> str:
        return self.name

    @property
    def is_class(self) -> bool:
        """Return whether objects are made of it."""
        return self.template is None

    def method(self, name: str) -> Function | None:
        """Return a method; None: there is none."""
        return (self.template or self).methods.get(name)

    def may_define(self, name: str) -> bool:
        """Return whether a program may add a property of this name."""
        return self.is_class or name.partition(".")[0] in self.spaces

    def put(self, world: World, name: str, kind: PropertyType, value: Any) -> None:
        """Add or set a property. Raises CommandError, LimitReached."""
        if name not in self.values and len(self.values) >= MOST_MEMBERS:
            raise CommandError(f"a custom object has at most {MOST_MEMBERS} properties")
        if not name or len(name) > _NAME_BYTES:
            raise CommandError(f"the name of a property has 1 to {_NAME_BYTES} characters")
        before = self.values.get(name)
        size = self.size - (0 if before is None else _size(name, *before)) + _size(name, kind, value)
        world.instances.resize(self, size)
        self.values[name] = kind, value

    def drop(self, world: World, name: str) -> None:
        """Remove a property. Raises CommandError: there is none."""
        if name not in self.values:
            raise CommandError(f"property is unknown: the object has no '{name[:40]}'")
        world.instances.resize(self, self.size - _size(name, *self.values[name]))
        del self.values[name]

    def new(self) -> CustomObject:
        """Return an object of this class with its first properties; it is not added yet."""
        made = CustomObject(self.name, self.supers, self.spaces, self, values=dict(self.values))
        made.size = self.size - len(self.model)
        return made


def _size(name: str, kind: PropertyType, value: Any) -> int:
    return len(name) + len(kind.encode(value))


def classes(world: World) -> Iterator[CustomObject]:
    """Return the classes that programs have made."""
    return (each for each in world.instances.all(CustomObject) if each.is_class)


def class_named(world: World, name: str) -> CustomObject | None:
    """Return the class of a name; None: there is none."""
    return next((each for each in classes(world) if each.name == name), None)


def custom_objects(world: World, *, in_app: bool) -> list[int]:
    """Return the handles of the objects of such classes that belong to the server, or to the scene."""
    found = world.instances.all(CustomObject)
    return [each.handle for each in found if not each.is_class and each.in_app == in_app]


def method_at(world: World, handle: int, name: str) -> Function | None:
    """Return the method that a program has given to a class of an object; None: there is none."""
    found = world.instances.find(handle)
    if isinstance(found, CustomObject):
        return found.method(name)
    if found is not None or handle not in world.simulation.scene.objects:
        return None
    return next(
        (each.methods[name] for each in classes(world) if handle in each.members and name in each.methods),
        None,
    )
