"""Copy elements of MjSpecs attribute by attribute: MjSpec itself copies only whole bodies of another spec.

`MjSpec.attach` is not suitable: a spec keeps hidden copies of everything attached to it, including all its default
classes and frames. Each copy of a scene's part would therefore double the remains of the copy before it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from collections.abc import Set as AbstractSet
from functools import cache
from typing import Any

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError

LEAVES = {"site": "sites", "camera": "cameras", "light": "lights", "geom": "geoms", "joint": "joints"}
"""Kinds of elements in a body, and the lists that contain them."""

_NOT_COPIED = frozenset(
    {
        *(
            "id",
            "signature",
            "parent",
            "frame",
            "frames",
            "classname",
            "compiler",
            "plugin",
            "info",
            "childclass",
        ),
        *("bodies", "geoms", "joints", "sites", "cameras", "lights", "path", "default"),
    }
)

_ACTING = ("actuator", "sensor", "equality", "pair", "exclude")
_REFERENCES = frozenset(
    {
        *("target", "refsite", "slidersite", "objname", "refname", "name1", "name2"),
        *("geomname1", "geomname2", "bodyname1", "bodyname2", "targetbody"),
    }
)
"""Attributes that name another element."""

_LISTS = {"equality": "equalities"}

_QUATERNION = mujoco.mjtOrientation.mjORIENTATION_QUAT

_ASSETS = {"meshname": "mesh", "hfieldname": "hfield", "material": "material"}
"""Attributes that name an asset, and its kind."""


class Copier:
    """Make twins of elements, whose names are made from the originals' by `rename`."""

    def __init__(
        self,
        rename: Callable[[str], str],
        *,
        references: bool = False,
        assets: Mapping[tuple[str, str], str] | None = None,
    ) -> None:
        """Store the renaming.

        Args:
            rename: returns the name of a twin.
            references: the names in references to other elements are renamed as well.
            assets: kind and name of an asset to the name of the one that twins have; others are renamed. None: twins
                have the same assets.
        """
        self._rename = rename
        self._references = references
        self._assets = assets

    def everything(self, source: mujoco.MjSpec, target: mujoco.MjSpec) -> None:
        """Copy all elements of a spec's world, and those that act on them, into another spec, which has the assets.

        Raises CommandError for plugins.
        """
        self._children(source.worldbody, target.worldbody)
        for tendon in source.tendons:
            twin = target.add_tendon()
            self.element(tendon, twin)
            self.path(tendon, twin)
        for kind in _ACTING:
            for element in getattr(source, _LISTS.get(kind, f"{kind}s")):
                self.element(element, getattr(target, f"add_{kind}")())

    def body(self, old: Any, new: Any) -> None:
        """Copy everything of a body and below into an empty one. Raises CommandError for plugins."""
        self.element(old, new)
        self._children(old, new)

    def leaves(
        self,
        old: Any,
        new: Any,
        kinds: Iterable[str] = LEAVES,
        without: AbstractSet[tuple[str, str]] = frozenset(),
    ) -> dict[Any, Any]:
        """Copy a body's own elements, with their frames; return original to twin. `without`: kinds and names."""
        frames: dict[Any, Any] = {}
        for kind in kinds:
            for leaf in getattr(old, LEAVES[kind]):
                if (kind, leaf.name) in without:
                    continue
                twin = getattr(new, f"add_{kind}")()
                self.element(leaf, twin)
                self.frame(leaf, twin, new, frames)
        return frames

    def element(self, old: Any, new: Any) -> None:
        """Copy the attributes of one element. Raises CommandError for plugins."""
        if getattr(getattr(old, "plugin", None), "active", False):
            raise CommandError(f"'{old.name}' uses a plugin and cannot be moved or copied")
        # mujoco has no types.
        form = _form_of(type(old))  # pyright: ignore[reportUnknownArgumentType]
        for name in form.values:  # arrays too: a spec's element takes over the numbers
            setattr(new, name, getattr(old, name))
        for name in form.lists:
            value = getattr(old, name)
            if len(value) or len(getattr(new, name)):  # writing one takes as long as all others together
                setattr(new, name, value)
        for name in form.orientations:
            _copy_orientation(getattr(old, name), getattr(new, name))
        if old.name:
            new.name = self._rename(old.name)
        for name in form.references if self._references else ():
            if (value := getattr(old, name)) and value != "world":
                setattr(new, name, self._rename(value))
        if self._assets is not None:
            self._rename_assets(old, new, form, self._assets)

    def _rename_assets(self, old: Any, new: Any, form: _Form, assets: Mapping[tuple[str, str], str]) -> None:
        for name in form.assets:
            setattr(new, name, self._asset(_ASSETS[name], getattr(old, name), assets))
        if "textures" in form.lists:
            new.textures = [self._asset("texture", each, assets) for each in old.textures]

    def _asset(self, kind: str, name: str, assets: Mapping[tuple[str, str], str]) -> str:
        return (assets.get((kind, name)) or self._rename(name)) if name else name

    def _children(self, old: Any, new: Any) -> None:
        frames = self.leaves(old, new)
        for child in old.bodies:
            twin = new.add_body()
            self.body(child, twin)
            self.frame(child, twin, new, frames)

    def frame(self, old: Any, new: Any, body: Any, frames: dict[Any, Any]) -> None:
        """Put a twin into a twin of its original's frame; `frames`: those the body has."""
        if old.frame is not None:
            new.set_frame(self._frame_twin(old.frame, body, frames))

    def _frame_twin(self, old: Any, body: Any, frames: dict[Any, Any]) -> Any:
        if old not in frames:
            twin = body.add_frame()
            self.element(old, twin)
            if old.frame is not None:
                twin.set_frame(self._frame_twin(old.frame, body, frames))
            frames[old] = twin
        return frames[old]

    def path(self, old: Any, new: Any) -> None:
        """Copy the path of a tendon."""
        for wrap in old.path:
            name = self._rename(wrap.target.name) if wrap.target is not None else ""
            if wrap.type == mujoco.mjtWrap.mjWRAP_PULLEY:
                new.wrap_pulley(wrap.divisor)
            elif wrap.type == mujoco.mjtWrap.mjWRAP_JOINT:
                new.wrap_joint(name, wrap.coef)
            elif wrap.type == mujoco.mjtWrap.mjWRAP_SITE:
                new.wrap_site(name)
            else:
                new.wrap_geom(name, self._rename(wrap.sidesite.name) if wrap.sidesite is not None else "")


@cache
def attributes_of(kind: type) -> tuple[str, ...]:
    """Return the names of the attributes that define an element of this class."""
    names = (name for name in dir(kind) if not name.startswith("_") and name not in _NOT_COPIED)
    return tuple(name for name in names if not callable(getattr(kind, name)))


@dataclass(frozen=True)
class _Form:
    """The attributes that define an element of a class, except its name, by how they are copied."""

    values: tuple[str, ...]
    lists: tuple[str, ...]
    orientations: tuple[str, ...]
    references: tuple[str, ...]
    assets: tuple[str, ...]
    """Both are among the values too."""


@cache
def _form_of(kind: type) -> _Form:
    one = _sample(kind)
    names = [name for name in attributes_of(kind) if name != "name"]
    orientations = tuple(name for name in names if name in ("alt", "ialt"))
    lists = tuple(
        name
        for name in names
        if hasattr(value := getattr(one, name), "__len__") and not isinstance(value, np.ndarray | str)
    )
    others = {*orientations, *lists}
    return _Form(
        values=tuple(name for name in names if name not in others),
        lists=lists,
        orientations=orientations,
        references=tuple(name for name in names if name in _REFERENCES),
        assets=tuple(name for name in names if name in _ASSETS),
    )


def _sample(kind: type) -> Any:
    """Return an element of a class."""
    spec: Any = mujoco.MjSpec()
    body = spec.worldbody.add_body()
    for parent in (body, spec):
        for name in dir(parent):
            if name.startswith("add_") and name not in ("add_default", "add_plugin"):
                made = getattr(parent, name)()
                if type(made) is kind:
                    return body if kind is type(body) else made
    raise TypeError(f"no element of a spec is a {kind.__name__}")


def _copy_orientation(old: Any, new: Any) -> None:
    if (kind := old.type) == new.type == _QUATERNION:
        return  # the other numbers are not used; nearly all elements are so
    new.type = kind
    for name in ("axisangle", "xyaxes", "zaxis", "euler"):
        getattr(new, name)[:] = getattr(old, name)


def agree(spec: mujoco.MjSpec, with_spec: mujoco.MjSpec) -> None:
    """Copy the other spec's settings of physics, images and memory: MuJoCo warns of different ones."""
    pairs = [(spec.option, with_spec.option), (spec.stat, with_spec.stat)]
    for part in ("global_", "headlight", "map", "quality", "rgba", "scale"):
        pairs.append((getattr(spec.visual, part), getattr(with_spec.visual, part)))
    for target, source in pairs:
        _write(target, source, [name for name in dir(source) if not name.startswith("_")])
    _write(spec, with_spec, [name for name in dir(spec) if name.startswith("n") or name == "memory"])


def _write(target: Any, source: Any, names: list[str]) -> None:
    for name in names:
        value = getattr(source, name)
        if isinstance(value, np.ndarray):
            getattr(target, name)[:] = value
        elif isinstance(value, int | float):
            setattr(target, name, value)
