"""Colours of shapes, which scripts set: by shape or by the name of a colour, for each component of V-REP.

A geom shows its own colour, or that of its material, which other geoms may share. Highlights and emission belong to
materials, so a geom gets a separate material when one of them is set. V-REP's emission is a separate
colour, MuJoCo's is a share of the geom's colour: the brighter of the two colours is shown.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from simx_client.protocol.python.light_dataclass import dataclass
from simx_server.errors import CommandError
from simx_server.scene.cameras.visibility import VISIBLE_GROUPS
from simx_server.scene.editing.recompile import edit
from simx_server.scene.formats.annotations.checks import place_of
from simx_server.scene.geometry.highlights import add_highlight, highlight_of
from simx_server.scene.objects import ObjectKind
from simx_server.scene.saved import numbers_text
from simx_server.simulation.part import Part

if TYPE_CHECKING:
    from simx_server.scene.editing.twins import Twins
    from simx_server.scene.saved import Saved
    from simx_server.simulation.simulation import Simulation

AMBIENT_DIFFUSE, DIFFUSE, SPECULAR, EMISSION, TRANSPARENCY, AUXILIARY = range(6)
"""`sim_colorcomponent_*`; the first two are the same for shapes."""

_UNSET = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom without one: then the colour of its material is used."""

_NEARLY = 1e-4
"""Added to a component where a script sets exactly the colour that means none."""

_OWN = "~own"
"""Marks materials made here: NAME~own3."""

_NUMBERED = re.compile(rf"(_\d+)?({_OWN}\d+)*")
"""Follows the name of a colour in the name of a material."""

_BLACK = (0.0, 0.0, 0.0)

Color = tuple[float, float, float]


@dataclass(frozen=True)
class _Look:
    """The colours of one geom, RGB 0..1, as V-REP has them."""

    diffuse: Color
    specular: Color
    emission: Color
    auxiliary: Color = _BLACK


@dataclass(frozen=True, slots=True)
class PartColors:
    """The colours of one part of a shape."""

    geom: int
    """MuJoCo's id of the geom."""
    colors: list[float]
    """RGB 0..1 of ambient and diffuse light, highlights and emission: 9 numbers."""
    transparency: float
    """0 opaque, 1 invisible."""


class ShapeColors(Part):
    """Reads and sets the colours of all shapes. The stop undoes a run's changes."""

    def __init__(self, sim: Simulation) -> None:
        self._sim = sim
        self._looks: dict[str, _Look] = {}
        """Colours that scripts have set, by the name of the geom."""
        self._before_the_run: dict[str, _Look] = {}
        self._read: set[int] = set()
        """Handles of shapes whose annotations were read."""

    def scene_changed(self) -> None:
        self._looks, self._read = {}, set()

    def model_changed(self, twins: Twins | None) -> None:
        self._read_annotations()

    def saving(self, saved: Saved) -> None:
        found: dict[int, list[str]] = {}
        for name, look in self._looks.items():
            geom = mujoco.mj_name2id(self._sim.model, mujoco.mjtObj.mjOBJ_GEOM, name)
            owner = self._sim.scene.owner_of_geom(geom, self._sim.model) if geom >= 0 else -1
            if owner in saved.names:
                values = (*look.diffuse, *look.specular, *look.emission, *look.auxiliary)
                found.setdefault(owner, []).append(f"{geom - self._first(owner)}:{numbers_text(values)}")
        for handle in self._sim.scene.of_kind(ObjectKind.SHAPE):
            if handle in saved.names:
                saved.put(handle, "shape", looks=";".join(sorted(found.get(handle, ()))) or None)

    def _read_annotations(self) -> None:
        """Take the colours that files give to objects which were not read yet."""
        scene, model = self._sim.scene, self._sim.model
        for name, notes in scene.annotations.objects.items():
            text = notes.get("shape", {}).get("looks")
            handle = scene.by_name(name) if text is not None else None
            if handle is None or handle in self._read:
                continue
            self._read.add(handle)
            for place, values in map(place_of, str(text).split(";")):
                geom = self._first(handle) + place
                if geom < model.ngeom and scene.owner_of_geom(geom, model) == handle:
                    r, g, b, sr, sg, sb, er, eg, eb, ar, ag, ab = values
                    look = _Look((r, g, b), (sr, sg, sb), (er, eg, eb), (ar, ag, ab))
                    self._looks.setdefault(model.geom(geom).name, look)

    def _first(self, handle: int) -> int:
        """Return the first geom of a shape."""
        item = self._sim.scene.objects[handle]
        return item.id if item.element == "geom" else int(self._sim.model.body_geomadr[item.body])

    def run_started(self) -> None:
        self._before_the_run = dict(self._looks)

    def run_stopped(self) -> None:
        self._looks = dict(self._before_the_run)

    def remember(self) -> object:
        return dict(self._looks)

    def recall(self, memory: Any) -> None:
        self._looks = dict(memory)

    def get(self, handle: int, component: int, name: str = "") -> list[float] | None:
        """Return the colour of a shape's first part (with this colour name); None without such a part.

        The transparency is given three times: 0 opaque, 1 invisible. Raises UnknownHandle, WrongKind, CommandError: no
        such component.
        """
        _check(component)
        geoms = self._geoms(handle, name)
        return self._get_of(geoms[0], component) if geoms else None

    def get_each(self, handle: int, component: int) -> list[list[float]]:
        """Return the colours of all parts of a shape, for `set_each`. Raises as `get`."""
        _check(component)
        return [self._get_of(geom, component) for geom in self._geoms(handle, "")]

    def parts(self, handle: int) -> list[PartColors]:
        """Return the parts of a shape that are drawn, or all if none is. Raises UnknownHandle, WrongKind."""
        components = (AMBIENT_DIFFUSE, SPECULAR, EMISSION)
        return [
            PartColors(
                geom,
                [value for component in components for value in self._get_of(geom, component)],
                self._get_of(geom, TRANSPARENCY)[0],
            )
            for geom in self._geoms(handle, "")
        ]

    def set_each(self, handle: int, component: int, colors: Sequence[Sequence[float]]) -> None:
        """Set the colours of all parts of a shape; parts beyond the given ones keep theirs. Raises as `set`."""
        _check(component)
        for geom, color in zip(self._geoms(handle, ""), colors, strict=False):
            self._set_of(geom, component, [*color, 0.0, 0.0, 0.0][:3])
        self._sim.model_edited()
        self._sim.changed()

    def set(self, handle: int, component: int, values: Sequence[float], name: str = "") -> int:
        """Set a colour of a shape, of all its parts or of those with a colour name; return how many there are.

        Raises UnknownHandle, WrongKind, CommandError: no such component, or too few values.
        """
        _check(component)
        if len(values) < (1 if component == TRANSPARENCY else 3):
            raise CommandError("a colour is {red, green, blue}, each 0 to 1")
        waiting = self._sim.waiting
        is_plain = component in (AMBIENT_DIFFUSE, TRANSPARENCY) and not name
        if is_plain and waiting is not None and handle in waiting.plain:
            waiting.call(lambda: self.set(handle, component, values))
            return 1  # a new shape has one part
        if component in (SPECULAR, EMISSION):
            self._give_materials(self._geoms(handle, name))
        geoms = self._geoms(handle, name)
        parts = [min(max(value, 0.0), 1.0) for value in values[:3]]
        for geom in geoms:
            self._set_of(geom, component, parts)
        self._sim.model_edited()
        self._sim.changed()
        return len(geoms)

    def _get_of(self, geom: int, component: int) -> list[float]:
        if component == TRANSPARENCY:
            return [1.0 - float(self._rgba(geom)[3])] * 3
        look = self._look(geom)
        colors = {SPECULAR: look.specular, EMISSION: look.emission, AUXILIARY: look.auxiliary}
        return list(colors.get(component, look.diffuse))

    def _set_of(self, geom: int, component: int, values: list[float]) -> None:
        model = self._sim.model
        rgba, look = self._rgba(geom).copy(), self._look(geom)
        if component == TRANSPARENCY:
            rgba[3] = 1.0 - values[0]
        else:
            color = (values[0], values[1], values[2])
            match component:
                case 2:
                    look = replace(look, specular=color)
                case 3:
                    look = replace(look, emission=color)
                case 5:
                    look = replace(look, auxiliary=color)
                case _:
                    look = replace(look, diffuse=color)
            self._looks[model.geom(geom).name] = look
        material = int(model.geom_matid[geom])
        highlight = highlight_of(model, material) if material >= 0 and self._is_own(material) else None
        glows = sum(look.emission) > sum(look.diffuse)
        rgba[:3] = look.emission if glows else look.diffuse
        if highlight is not None:
            share = 1.0 if glows else sum(look.emission) / max(sum(look.diffuse), 1e-6)
            model.mat_emission[material] = share
            model.mat_specular[material] = sum(look.specular) / 3
            highlight[:] = look.specular
        if material >= 0 and _is_unset(rgba):
            rgba[0] += _NEARLY
        model.geom_rgba[geom] = rgba

    def _look(self, geom: int) -> _Look:
        """Return the colours of a geom as they were set, or as its material says."""
        known = self._looks.get(self._sim.model.geom(geom).name)
        if known is not None:
            return known
        model, material = self._sim.model, int(self._sim.model.geom_matid[geom])
        red, green, blue = self._rgba(geom)[:3].tolist()
        diffuse = (red, green, blue)
        if material < 0:
            return _Look(diffuse, (0.25, 0.25, 0.25), _BLACK)
        emission = float(model.mat_emission[material])
        highlight = highlight_of(model, material)
        specular = np.repeat(model.mat_specular[material], 3) if highlight is None else highlight
        glow = (red * emission, green * emission, blue * emission)
        return _Look(diffuse, (float(specular[0]), float(specular[1]), float(specular[2])), glow)

    def _rgba(self, geom: int) -> np.ndarray:
        """Return the colour that a geom shows."""
        model = self._sim.model
        rgba, material = model.geom_rgba[geom], int(model.geom_matid[geom])
        return model.mat_rgba[material] if material >= 0 and _is_unset(rgba) else rgba

    def _geoms(self, handle: int, name: str) -> list[int]:
        """Return the geoms of a shape that are drawn, or all if none is; with a name those of that colour."""
        sim = self._sim
        item = sim.scene.get_kind(handle, ObjectKind.SHAPE)
        model = sim.model
        found = [
            geom
            for geom in ([item.id] if item.element == "geom" else _of_body(model, item.id))
            if sim.scene.owner_of_geom(geom, model) == handle
        ]
        if name:
            return [geom for geom in found if self._has_name(geom, name)]
        drawn = [
            geom
            for geom in found
            if sim.scene.withheld.get((model.geom(geom).name, "geom_group"), model.geom_group[geom])
            in VISIBLE_GROUPS
        ]
        return drawn or found

    def _has_name(self, geom: int, name: str) -> bool:
        """Return whether a geom's material was made of a colour with this name."""
        material = int(self._sim.model.geom_matid[geom])
        if material < 0:
            return False
        own = self._sim.model.mat(material).name.rpartition("/")[2]
        if len(name) > len(own):  # a client may send a megabyte
            return False
        stem = "".join(letter if letter.isalnum() else "_" for letter in name)
        return own.startswith(stem) and _NUMBERED.fullmatch(own, len(stem)) is not None

    def _is_own(self, material: int) -> bool:
        """Return whether a material was made here and belongs to a single geom.

        A material with such a name from a file may have no colour of highlights.
        """
        model = self._sim.model
        return (
            _OWN in model.mat(material).name
            and highlight_of(model, material) is not None
            and np.count_nonzero(model.geom_matid == material) == 1
        )

    def _give_materials(self, geoms: list[int]) -> None:
        """Give each of these geoms a material that no other one has."""
        model = self._sim.model
        wanting = [
            geom
            for geom in geoms
            if model.geom_matid[geom] < 0 or not self._is_own(int(model.geom_matid[geom]))
        ]
        if not wanting:
            return

        def surgery(spec: mujoco.MjSpec) -> None:
            for geom in wanting:
                _add_material(spec, model, geom)

        edit(self._sim, surgery, set())


def _of_body(model: mujoco.MjModel, body: int) -> range:
    start = int(model.body_geomadr[body])
    return range(start, start + int(model.body_geomnum[body]))


def _add_material(spec: mujoco.MjSpec, model: mujoco.MjModel, geom: int) -> None:
    """Give a geom of the spec a copy of its material, or a new one."""
    target: Any = spec.geom(model.geom(geom).name)
    material = int(model.geom_matid[geom])
    stem = model.mat(material).name if material >= 0 else "color"
    name = next(each for number in count() if spec.material(each := f"{stem}{_OWN}{number}") is None)
    made: Any = spec.add_material(name=name)
    if material >= 0:
        source: Any = spec.material(stem)
        for field in ("shininess", "reflectance", "metallic", "roughness", "texuniform", "texrepeat"):
            setattr(made, field, getattr(source, field))
        for role, texture in enumerate(source.textures):
            if texture:
                made.textures[role] = texture
        made.rgba = model.mat_rgba[material].tolist()
        made.emission, made.specular = model.mat_emission[material], model.mat_specular[material]
    else:
        made.rgba = model.geom_rgba[geom].tolist()
        made.specular = 0.25
    highlight = None if material < 0 else highlight_of(model, material)
    add_highlight(spec, name, [float(made.specular)] * 3 if highlight is None else highlight.tolist())
    target.material = name


def _is_unset(rgba: np.ndarray) -> bool:
    """Return whether a colour of a geom is that of geoms without one."""
    red, green, blue, alpha = rgba.tolist()
    # `allclose` takes 50 times as long.
    if abs(red - _UNSET[0]) > _NEARLY or abs(alpha - _UNSET[3]) > _NEARLY:
        return False
    return (red, green, blue, alpha) == _UNSET or bool(np.allclose(rgba, _UNSET))


def _check(component: int) -> None:
    if not AMBIENT_DIFFUSE <= component <= AUXILIARY:
        raise CommandError(
            f"{component} is no component of a colour; those are 0 ambient and diffuse, 2 specular, 3 emission, "
            "4 transparency, 5 auxiliary"
        )
