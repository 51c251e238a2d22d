"""Add a whole spec to another: its names get a prefix, and assets that both have are shared.

The elements are copied where that means the same, because `MjSpec.attach` leaves hidden copies of all that was ever
attached: the spec of a scene in which programs load and remove models would grow with each, and every edit with it.
"""

from __future__ import annotations

import logging
from collections import defaultdict
from typing import Any

import mujoco
import numpy as np

from simx_server.scene import physics_warnings
from simx_server.scene.assets.naming import is_name, rename_attached, take_files
from simx_server.scene.geometry.highlights import SPECULAR

from .element_copies import Copier, agree, attributes_of

logger = logging.getLogger(__name__)

_COMPILER = (
    "alignfree", "autolimits", "balanceinertia", "boundinertia", "boundmass", "discardvisual", "fitaabb",
    "inertiafromgeom", "inertiagrouprange", "settotalmass",
)  # fmt: skip
"""Settings of a compiler that belong to each element. Angles are in radians, and files in memory need no folder."""


def weight_of(part: Any, spec: mujoco.MjSpec) -> float | None:
    """Return how much `join` adds, as a number of bodies; None if it should not be made again in another copy."""
    if not _can_be_copied(part, spec):
        return None
    numbers = sum(len(mesh.uservert) + len(mesh.userface) for mesh in part.meshes)
    return len(part.bodies) + numbers / _NUMBERS


_NUMBERS = 100
"""Numbers of meshes that are copied in the time in which a body is added: they are read one by one."""


def join(part: mujoco.MjSpec, spec: mujoco.MjSpec, prefix: str) -> None:
    """Add all of a spec to another one, at the top. Raises CommandError, ValueError.

    Its names get the prefix. Of meshes and images that are alike, only the first is there afterwards.
    """
    if _can_be_copied(part, spec):
        _copy(part, spec, prefix)
    else:
        _attach(part, spec, prefix)
        if any(map(len, (part.meshes, part.textures, part.materials, part.hfields))):
            spec.dedup_assets()


def _can_be_copied(part: Any, spec: Any) -> bool:
    """Return whether copied elements would be compiled as they are in their own spec."""
    files = [each.file for many in (part.meshes, part.textures, part.hfields) for each in many]
    cubes = [file for texture in part.textures for file in texture.cubefiles]
    return (
        not any(map(len, (part.flexes, part.skins, part.plugins, part.tuples, part.keys)))
        and all(not file or is_name(file) for file in files + cubes)
        and all(_are_equal(getattr(part.compiler, name), getattr(spec.compiler, name)) for name in _COMPILER)
    )


def _copy(part: Any, spec: Any, prefix: str) -> None:
    shared: dict[tuple[str, str], str] = {}
    copier = Copier(lambda name: prefix + name, references=True, assets=shared)
    for kind in ("texture", "mesh"):
        known: dict[str, list[Any]] = defaultdict(list)
        for each in getattr(spec, _LISTS[kind]):
            known[each.file].append(each)
        for asset in getattr(part, _LISTS[kind]):
            others = known[asset.file] if is_name(asset.file) else []
            if (other := next((each for each in others if _are_alike(asset, each)), None)) is not None:
                shared[kind, asset.name] = other.name
            else:
                copier.element(asset, twin := getattr(spec, f"add_{kind}")())
                known[asset.file].append(twin)
    for kind in ("hfield", "material", "text"):
        for element in getattr(part, f"{kind}s"):
            copier.element(element, getattr(spec, f"add_{kind}")())
    for numeric in part.numerics:
        twin = spec.add_numeric(name=_numeric_name(numeric.name, prefix))
        twin.data, twin.size = numeric.data, numeric.size
    copier.everything(part, spec)
    spec.assets.update(part.assets)


_LISTS = {"texture": "textures", "mesh": "meshes"}


def _attach(part: mujoco.MjSpec, spec: mujoco.MjSpec, prefix: str) -> None:
    part = part.copy()  # it is changed
    agree(part, spec)
    files = take_files(part) | take_files(spec)
    with physics_warnings.collected() as told:
        spec.attach(part, prefix=prefix, frame=spec.worldbody.add_frame())
    rename_attached(spec)
    spec.assets.update(files)
    for sensor in spec.sensors:
        if sensor.refname == prefix:  # it had no reference
            sensor.refname = ""
    for numeric in spec.numerics:
        if numeric.name.startswith(prefix):
            numeric.name = _numeric_name(numeric.name.removeprefix(prefix), prefix)
    for warning in told:
        # This warning concerns a scene with its files' bytes and a model without: no file is missing then.
        if not str(warning).startswith("Attaching a child without asset dict"):
            logger.warning("mujoco: %s", warning)


def _numeric_name(name: str, prefix: str) -> str:
    """Return the new name of a numeric; that of a highlight has the name of its material, which gets the prefix."""
    return SPECULAR + prefix + name.removeprefix(SPECULAR) if name.startswith(SPECULAR) else prefix + name


def _are_alike(one: Any, other: Any) -> bool:
    """Return whether two assets differ in nothing but their names."""
    return all(
        _are_equal(getattr(one, name), getattr(other, name))
        for name in attributes_of(type(one))  # pyright: ignore[reportUnknownArgumentType]
        if name != "name"
    )


def _are_equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray):
        return bool((one == other).all())  # arrays of one attribute have one shape
    if hasattr(one, "__len__") and not isinstance(one, str | bytes):
        # Iterators of mujoco's lists take 80 us each.
        return len(one) == len(other) and all(one[index] == other[index] for index in range(len(one)))
    return bool(one == other)
