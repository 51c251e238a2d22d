"""Values of a scene that may be fitted: where each stands in MJCF or in an annotation, and its usual bounds."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from simx_client.protocol.nearest import did_you_mean
from simx_server.errors import CommandError
from simx_server.scene.formats.annotations.annotation import PREFIX
from simx_server.scene.formats.annotations.reading import parse
from simx_server.scene.formats.annotations.writing import note_text

if TYPE_CHECKING:
    import mujoco

    Spec = mujoco.MjSpec


@dataclass(frozen=True)
class Place:
    """Where a value stands, for objects of one kind. All values are above 0."""

    get: Callable[[Spec, str], float | None]
    """Returns the value of the object; None: the object has none of this kind."""

    put: Callable[[Spec, str, float], None]
    least: float
    most: float
    """The bounds where the user gives none."""

    written: str
    """The form in a scene's file, with the name and the value to fill in."""

    meaning: str


@dataclass(frozen=True)
class Free:
    """One value that is fitted."""

    owner: str
    name: str
    start: float
    least: float
    most: float
    place: Place

    def put(self, spec: Spec, value: float) -> None:
        """Write a value into a scene. Raises CommandError: the scene lacks it."""
        if self.place.get(spec, self.owner) is None:
            raise CommandError(f"the recording is of another scene: it has no {self.name} of '{self.owner}'")
        self.place.put(spec, self.owner, value)

    def written(self, value: float) -> str:
        """Return the value as it stands in a scene's file."""
        return self.place.written.format(name=self.owner, value=f"{value:.6g}")

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}"


def _attribute(name: str) -> tuple[Callable[[Spec, str], float | None], Callable[[Spec, str, float], None]]:
    """Return reader and writer of an attribute of a joint."""

    def get(spec: Spec, owner: str) -> float | None:
        joint: Any = spec.joint(owner)
        if joint is None:
            return None
        value = getattr(joint, name)
        return float(value) if isinstance(value, (int, float)) else float(value[0])

    def put(spec: Spec, owner: str, value: float) -> None:
        joint: Any = spec.joint(owner)
        if isinstance(getattr(joint, name), (int, float)):
            setattr(joint, name, value)
        else:
            getattr(joint, name)[0] = value

    return get, put


def _text(spec: Spec, owner: str) -> Any:
    return next((text for text in spec.texts if text.name == f"{PREFIX}joint:{owner}"), None)


_DEFAULTS = {"P": 0.1, "I": 0.0, "D": 0.0, "K": 0.1, "C": 0.0}
"""Of annotations that lack the key (docs/annotations.md)."""


def _annotation(key: str) -> tuple[Callable[[Spec, str], float | None], Callable[[Spec, str, float], None]]:
    """Return reader and writer of a key of a joint's annotation."""

    def get(spec: Spec, owner: str) -> float | None:
        text = _text(spec, owner)
        if text is None:
            return None
        value = parse("joint", text.data, text.name).get(key, _DEFAULTS.get(key))
        return None if value is None else abs(float(value))

    def put(spec: Spec, owner: str, value: float) -> None:
        text = _text(spec, owner)
        note = parse("joint", text.data, text.name)
        old = note.get(key)
        note[key] = -value if isinstance(old, float) and old < 0 else value
        text.data = note_text(note)

    return get, put


def _geoms(spec: Spec, owner: str) -> Sequence[Any]:
    """Return the geoms of a shape, which is a body, or a geom by its name."""
    body: Any = spec.body(owner)
    if body is not None:
        return list(body.geoms)
    geom: Any = spec.geom(owner)
    return [] if geom is None else [geom]


def _contact(name: str) -> tuple[Callable[[Spec, str], float | None], Callable[[Spec, str, float], None]]:
    """Return reader and writer of the first number of an attribute of all geoms of a shape."""

    def get(spec: Spec, owner: str) -> float | None:
        geoms = _geoms(spec, owner)
        return float(getattr(geoms[0], name)[0]) if geoms else None

    def put(spec: Spec, owner: str, value: float) -> None:
        for geom in _geoms(spec, owner):
            getattr(geom, name)[0] = value

    return get, put


def _gain(
    place: int, sign: float, is_kp: bool
) -> tuple[Callable[[Spec, str], float | None], Callable[[Spec, str, float], None]]:
    """Return reader and writer of a gain of the position actuator of a joint."""

    def find(spec: Spec, owner: str) -> Any:
        return next((a for a in spec.actuators if a.target == owner and a.biasprm[1] < 0), None)

    def get(spec: Spec, owner: str) -> float | None:
        actuator = find(spec, owner)
        return None if actuator is None else float(sign * actuator.biasprm[place])

    def put(spec: Spec, owner: str, value: float) -> None:
        actuator = find(spec, owner)
        actuator.biasprm[place] = sign * value
        if is_kp:
            actuator.gainprm[0] = value

    return get, put


_JOINT = '<joint name="{{name}}" {}="{{value}}"/>'
_NOTE = '<text name="simx:joint:{{name}}" data="... {}={{value}}"/>'
_GEOM = '<geom {}="{{value}} ..."/> of {{name}}'
_POSITION = '<position joint="{{name}}" {}="{{value}}"/>'

PLACES: Mapping[str, tuple[Place, ...]] = MappingProxyType(
    {
        "friction": (
            Place(
                *_attribute("frictionloss"),
                1e-4,
                1e3,
                _JOINT.format("frictionloss"),
                "joint: dry friction, N m or N",
            ),
            Place(*_contact("friction"), 1e-2, 5.0, _GEOM.format("friction"), "shape: sliding friction"),
        ),
        "damping": (
            Place(*_attribute("damping"), 1e-4, 1e3, _JOINT.format("damping"), "joint: N m s/rad or N s/m"),
        ),
        "armature": (
            Place(*_attribute("armature"), 1e-5, 1e2, _JOINT.format("armature"), "joint: kg m2 or kg"),
        ),
        "kp": (
            Place(
                *_gain(1, -1.0, True),
                1e-2,
                1e5,
                _POSITION.format("kp"),
                "joint: gain of its position actuator",
            ),
        ),
        "kv": (
            Place(
                *_gain(2, -1.0, False), 1e-3, 1e4, _POSITION.format("kv"), "joint: damping of that actuator"
            ),
        ),
        "P": (
            Place(
                *_annotation("P"), 1e-3, 1.0, _NOTE.format("P"), "joint: gain of V-REP's position controller"
            ),
        ),
        "I": (Place(*_annotation("I"), 1e-4, 1.0, _NOTE.format("I"), "joint: its integral part"),),
        "D": (Place(*_annotation("D"), 1e-4, 1.0, _NOTE.format("D"), "joint: its derivative part"),),
        "K": (
            Place(
                *_annotation("K"),
                1e-3,
                1e5,
                _NOTE.format("K"),
                "joint: spring constant of V-REP's spring mode",
            ),
        ),
        "C": (Place(*_annotation("C"), 1e-3, 1e4, _NOTE.format("C"), "joint: damping of that mode"),),
        "max_force": (
            Place(
                *_annotation("max_force"),
                1e-3,
                1e4,
                _NOTE.format("max_force"),
                "joint: its motor's greatest force",
            ),
        ),
        "softness": (
            Place(
                *_contact("solref"),
                1e-3,
                1.0,
                _GEOM.format("solref"),
                "shape: time constant of its contacts, s",
            ),
        ),
    }
)
"""The names of values, and where each stands."""

VALID = f"valid is OBJECT.NAME or OBJECT.NAME=LOW:HIGH with a NAME of {', '.join(PLACES)}"


def free_of(text: str, spec: Spec) -> Free:
    """Return a value to fit by the text of a user.

    Args:
        text: ``OBJECT.NAME`` or ``OBJECT.NAME=LOW:HIGH``.
        spec: the scene.

    Raises:
        CommandError: the scene has no such value; the text says what is valid.
    """
    match = re.fullmatch(r"(.+?)\.([^.=\s]+)(?:=([^:=]+):([^:=]+))?", text)
    if match is None:
        raise CommandError(f"'{text}' is no value of a scene; {VALID}")
    owner, name = match[1], match[2]
    if name not in PLACES:
        raise CommandError(f"there is no value '{name}'{did_you_mean(name, PLACES)}; {VALID}")
    for place in PLACES[name]:
        start = place.get(spec, owner)
        if start is not None:
            least, most = _bounds(match[3], match[4], place, text)
            return Free(owner, name, min(max(start, least), most), least, most, place)
    wanted = " or ".join(place.meaning for place in PLACES[name])
    raise CommandError(f"the scene has no {name} of '{owner}' ({wanted}); {_known(spec, owner)}")


def _bounds(low: str | None, high: str | None, place: Place, text: str) -> tuple[float, float]:
    if low is None or high is None:
        return place.least, place.most
    try:
        least, most = float(low), float(high)
    except ValueError:
        least = most = 0.0
    if not 0 < least < most < float("inf"):
        raise CommandError(f"the bounds of '{text}' must be two rising numbers above 0, such as 0.01:10")
    return least, most


def _known(spec: Spec, owner: str) -> str:
    names = [each.name for each in (*spec.joints, *spec.bodies, *spec.geoms) if each.name]
    if owner in names:
        return "P, I, D, K, C and max_force need an annotation simx:joint of the joint, kp and kv its position actuator"
    return f"it has no such object{did_you_mean(owner, names)}"
