"""Annotations of a scene: `<custom>` elements with the prefix `simx` for all settings that MJCF lacks.

`<text name="simx:KIND:OBJECT" data="key=value key=value"/>`; `<numeric name="simx:time_step" data="0.05"/>`.
Scripts have other forms, see `script_texts.py`.
GRAMMAR is the whole list of kinds and keys; all others are errors that name the element and the valid values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import mujoco

from simx_server.errors import CommandError
from simx_server.scene.formats.script_texts import SCRIPT_TYPES, TEXT_KINDS, place_script

PREFIX = "simx:"

Value = float | bool | str
Annotation = dict[str, Value]


class SceneError(CommandError):
    """A scene file that cannot be loaded; the text names the element and the valid values."""


@dataclass
class Annotations:
    """All annotations of a scene: per object name, per kind, checked values; and those of the scene itself."""

    objects: dict[str, dict[str, Annotation]] = field(default_factory=dict[str, dict[str, Annotation]])
    registered: dict[str, dict[str, Annotation]] = field(default_factory=dict[str, dict[str, Annotation]])
    """Registered entries by kind of REGISTERED and name; these names are not names of objects."""
    main_script: Annotation | None = None
    time_step: float | None = None


def _switch(text: str) -> bool:
    words = {"on": True, "yes": True, "true": True, "off": False, "no": False, "false": False}
    if text.lower() not in words:
        raise ValueError("on/yes or off/no")
    return words[text.lower()]


def _number(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError("a finite number")
    return value


def _positive(text: str) -> float:
    value = _number(text)
    if value <= 0:
        raise ValueError("a number above 0")
    return value


def _not_negative(text: str) -> float:
    value = _number(text)
    if value < 0:
        raise ValueError("a number not below 0")
    return value


def _angle(text: str) -> float:
    value = _number(text)
    if not 0 < value <= 360:
        raise ValueError("degrees above 0, up to 360")
    return value


def _share(text: str) -> float:
    value = _number(text)
    if not 0 <= value < 1:
        raise ValueError("a number from 0 up to, but not, 1")
    return value


def _count(text: str) -> float:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 10_000:
        raise ValueError("a whole number from 1 to 10000")
    return int(text)


def _one_of(*words: str) -> Callable[[str], str]:
    def check(text: str) -> str:
        if text not in words:
            raise ValueError("one of " + ", ".join(words))
        return text

    return check


def _some_of(*words: str) -> Callable[[str], str]:
    def check(text: str) -> str:
        if not text or not set(text.split(",")) <= set(words):
            raise ValueError("some of " + ", ".join(words) + " with commas between them")
        return text

    return check


GRAMMAR: dict[str, dict[str, Callable[[str], Value]]] = {
    "joint": {
        "mode": _one_of("force", "passive", "ik", "dependent", "motion"),
        "motor": _switch,
        "control": _one_of("position", "velocity", "spring"),
        "P": _not_negative,
        "I": _not_negative,
        "D": _not_negative,
        "K": _number,
        "C": _number,
        "upper_velocity": _positive,
        "max_force": _not_negative,
        "lock": _switch,
        "hybrid": _switch,
        "rewind": _switch,
        "cyclic": _switch,
        "switches": _switch,
        "target_position": _number,
        "target_velocity": _number,
        "parent": str,
        "offset": _number,
        "master": str,
        "multiplication": _number,
    },
    "vision": {
        "near": _positive,
        "far": _positive,
        "angle_deg": _positive,
        "explicit": _switch,
        "external": _switch,
        "render": _one_of("colours", "handles"),
        "detect_above": _share,
        "detect_below": _share,
    },
    "camera": {"view": _switch},
    "proximity": {
        "type": _one_of("ray", "cone", "cylinder", "pyramid", "disc"),
        "offset": _not_negative,
        "range": _positive,
        "explicit": _switch,
        "angle_deg": _angle,
        "radius": _not_negative,
        "radius_far": _not_negative,
        "size_x": _positive,
        "size_y": _positive,
        "size_x_far": _positive,
        "size_y_far": _positive,
        "height": _positive,
        "inside_gap": _share,
        "faces": _one_of("both", "front", "back"),
        "max_normal_deg": _angle,
        "min_distance": _not_negative,
        "entity": str,
    },
    "force": {
        "max_force": _positive,
        "max_torque": _positive,
        "violations": _count,
        "samples": _count,
        "filter": _one_of("average", "median"),
    },
    "shape": {"detectable": _switch, "collidable": _switch, "measurable": _switch},
    "collection": {
        "objects": str,
        "tree": str,
        "below": str,
        "chain": str,
        "all": _switch,
        "without": str,
    },
    "collision": {"entity1": str, "entity2": str, "explicit": _switch},
    "distance": {"entity1": str, "entity2": str, "explicit": _switch},
    "parameters": {},
    "script": {"file": str, "type": _one_of(*SCRIPT_TYPES), "threaded": _switch},
    **{kind: {} for kind in TEXT_KINDS},
    "ik": {
        "tip": str,
        "target": str,
        "base": str,
        "constraints": _some_of("pose", "position", "orientation", "x", "y", "z", "alpha_beta", "gamma"),
        "damping": _not_negative,
        "iterations": _count,
        "handling": _one_of("auto", "explicit"),
    },
    "model": {"base": _switch},
    "mount": {"on": str, "ahead": _number},
    "copies": {"count": _count, "x": _number, "y": _number, "z": _number, "turn_deg": _number},
    "ui": {"file": str},
}

FREE = ("parameters",)
"""Kinds that accept any key, for scripts to read; values stay texts."""


REGISTERED = ("collection", "collision", "distance", "ik", "ui")
"""Kinds whose NAME is a separate name, not that of an object."""

MEASURED = ("collection", "collision", "distance", "ik")
"""Registered kinds that a model brings along."""

_VOLUMES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "ray": ((), ()),
    "cone": (("angle_deg",), ("radius", "inside_gap")),
    "cylinder": (("radius",), ("radius_far",)),
    "pyramid": (("size_x", "size_y"), ("size_x_far", "size_y_far")),
    "disc": (("angle_deg", "height"), ("radius", "inside_gap")),
}
"""Keys that each type of proximity sensor needs, and its optional keys."""
_ANY_VOLUME = {key for needed, possible in _VOLUMES.values() for key in (*needed, *possible)}


def read_annotations(spec: mujoco.MjSpec) -> Annotations:
    """Collect and check the annotations of a spec. Raises SceneError."""
    found = Annotations()
    for text in spec.texts:
        if text.name.startswith(PREFIX):
            kind, name = _split_name(text.name)
            is_script = kind in TEXT_KINDS
            note = {"text": text.data, "language": kind} if is_script else parse(kind, text.data, text.name)
            if is_script or kind == "script":
                name, kind = place_script(name, note)
            if not name:
                found.main_script = note
            elif kind in REGISTERED:
                found.registered.setdefault(kind, {}).setdefault(name, {}).update(note)
            else:
                found.objects.setdefault(name, {}).setdefault(kind, {}).update(note)
    for numeric in spec.numerics:
        if numeric.name == PREFIX + "time_step":
            values = list(numeric.data)
            if len(values) != 1 or not 0 < values[0] <= 10:
                raise SceneError(
                    f"numeric '{numeric.name}' has data {values}; valid is one number above 0, up to 10 s"
                )
            found.time_step = float(values[0])
        elif numeric.name.startswith(PREFIX):
            raise SceneError(f"numeric '{numeric.name}' is not known; valid is '{PREFIX}time_step'")
    return found


def parse(kind: str, data: str, element: str) -> Annotation:
    """Return the checked values of one annotation; `element` is named in errors. Raises SceneError."""
    keys = GRAMMAR[kind]
    values: Annotation = {}
    for word in data.split():
        key, sign, text = word.partition("=")
        if sign and key and kind in FREE:
            values[key] = text
            continue
        if not sign or key not in keys:
            raise SceneError(
                f"text '{element}' has '{word}'; valid is key=value with a key of {', '.join(keys)}"
            )
        try:
            values[key] = keys[key](text)
        except ValueError as error:
            raise SceneError(f"text '{element}' has '{word}'; valid for {key} is {error}") from None
    if kind == "proximity":
        _check_volume(values, element)
    return values


def _check_volume(values: Annotation, element: str) -> None:
    kind = str(values.get("type", "ray"))
    needed, possible = _VOLUMES[kind]
    given = values.keys() & _ANY_VOLUME
    if missing := [key for key in needed if key not in given]:
        raise SceneError(f"text '{element}' is of type {kind}, which needs {', '.join(missing)}")
    if surplus := sorted(given - {*needed, *possible}):
        valid = ", ".join((*needed, *possible)) or "no size"
        raise SceneError(f"text '{element}' is of type {kind}, which has no {surplus[0]}; it has {valid}")
    if kind == "cylinder" and not values["radius"] and not values.get("radius_far"):
        raise SceneError(f"text '{element}' has radius=0; then radius_far must be above 0")


def check_objects(annotations: Annotations, kinds_of: dict[str, str]) -> None:
    """Check that annotated objects exist and have the kind of their annotation. `kinds_of`: name to kind text."""
    needed = {
        "joint": "joint",
        "vision": "vision sensor",
        "camera": "camera",
        "proximity": "proximity sensor",
        "force": "force sensor",
        "shape": "shape",
    }
    for name, by_kind in annotations.objects.items():
        for kind in by_kind:
            if name not in kinds_of:
                raise SceneError(
                    f"text '{PREFIX}{kind}:{name}' names no object of the scene; names are those of bodies, "
                    "joints, cameras, sites, lights and driven tendons"
                )
            wanted = needed.get(kind)
            if wanted is not None and kinds_of[name] not in (
                wanted,
                "camera" if kind == "vision" else wanted,
            ):
                raise SceneError(
                    f"text '{PREFIX}{kind}:{name}' is for a {wanted}, but '{name}' is a {kinds_of[name]}"
                )
    _check_names(annotations, kinds_of)


def _check_names(annotations: Annotations, objects: Collection[str]) -> None:
    """Check that the objects named by collections, collision and distance objects and sensors exist."""
    collections = annotations.registered.get("collection", {})
    for name, note in collections.items():
        for key in ("objects", "tree", "below", "chain", "without"):
            for word in filter(None, str(note.get(key, "")).split(",")):
                _must_name(f"collection:{name}", key, word, objects, "object")
    entities = {"all", *objects, *collections}
    for kind in ("collision", "distance"):
        for name, note in annotations.registered.get(kind, {}).items():
            for key in ("entity1", "entity2"):
                _must_name(f"{kind}:{name}", key, str(note.get(key, "all")), entities, "object or collection")
            if note.get("entity1", "all") == "all":
                raise SceneError(f"text '{PREFIX}{kind}:{name}' needs entity1=, an object or collection")
    for name, note in annotations.registered.get("ik", {}).items():
        for key in ("tip", "target", "base"):
            if key != "base" or key in note:
                _must_name(f"ik:{name}", key, str(note.get(key, "")), objects, "object")
    for name, by_kind in annotations.objects.items():
        word = str(by_kind.get("proximity", {}).get("entity", "all"))
        _must_name(f"proximity:{name}", "entity", word, entities, "object or collection")


def _must_name(element: str, key: str, word: str, known: Collection[str], what: str) -> None:
    if word not in known:
        raise SceneError(f"text '{PREFIX}{element}' has {key}={word}, which is no {what} of the scene")


def _split_name(full: str) -> tuple[str, str]:
    kind, sign, name = full.removeprefix(PREFIX).partition(":")
    if kind not in GRAMMAR or not sign or not name:
        raise SceneError(
            f"text '{full}' is not known; valid is '{PREFIX}KIND:OBJECT' with a KIND of {', '.join(GRAMMAR)}"
        )
    return kind, name
