"""Collect the annotations of a scene and check their values."""

from __future__ import annotations

from typing import TYPE_CHECKING

from simx_server.scene.formats.texts.old_uis import UI_TEXT, read_ui_text
from simx_server.scene.formats.texts.scripts import TEXT_KINDS, place_script
from simx_server.scene.formats.texts.values import decode

from .annotation import PREFIX, Annotation, Annotations, SceneError
from .grammar import FREE, GRAMMAR, REGISTERED, WORLD
from .ros2_keys import check_keys

if TYPE_CHECKING:
    import mujoco

_LONGEST_WORD = 200
"""Characters of a wrong word that a message shows."""

VOLUMES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "ray": ((), ()),
    "cone": (("angle_deg",), ("radius", "inside_gap")),
    "cylinder": (("radius",), ("radius_far",)),
    "pyramid": (("size_x", "size_y"), ("size_x_far", "size_y_far")),
    "disc": (("angle_deg", "height"), ("radius", "inside_gap")),
    "random_rays": (("angle_deg",), ("radius", "inside_gap", "rays", "rays_needed")),
}
"""Keys that each type of proximity sensor needs, and its optional keys."""
_ANY_VOLUME = {key for needed, possible in VOLUMES.values() for key in (*needed, *possible)}


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
            _file(found, kind, name, note)
    for numeric in spec.numerics:
        if numeric.name == PREFIX + "time_step":
            found.time_step = _read_time_step(list(numeric.data))
        elif numeric.name.startswith(f"{PREFIX}specular:"):
            _check_color(numeric.name, list(numeric.data))
        elif numeric.name.startswith(PREFIX):
            raise SceneError(
                f"numeric '{numeric.name}' is not known; valid are '{PREFIX}time_step' and '{PREFIX}specular:MATERIAL'"
            )
    return found


def _file(found: Annotations, kind: str, name: str, note: Annotation) -> None:
    """Store an annotation at its place. `name`: empty for a main script."""
    if not name:
        found.main_script = {**(found.main_script or {}), **note}
    elif (kind, name) == ("data", WORLD):
        found.data.update(note)
    elif (kind, name) == ("ros2", WORLD):
        found.ros2.update(note)
    elif kind == "scene":
        if name != WORLD:
            raise SceneError(f"text '{PREFIX}scene:{name}' is not known; valid is '{PREFIX}scene:{WORLD}'")
        found.scene.update(note)
    else:
        is_registered = kind in REGISTERED
        first, second = (kind, name) if is_registered else (name, kind)
        place = found.registered if is_registered else found.objects
        place.setdefault(first, {}).setdefault(second, {}).update(note)


def _check_color(name: str, values: list[float]) -> None:
    if len(values) != 3 or not all(0 <= value <= 1 for value in values):
        raise SceneError(
            f"numeric '{name}' has data {values}; valid are red, green and blue, each from 0 to 1"
        )


def _read_time_step(values: list[float]) -> float:
    if len(values) != 1 or not 0 < values[0] <= 10:
        raise SceneError(
            f"numeric '{PREFIX}time_step' has data {values}; valid is one number above 0, up to 10 s"
        )
    return float(values[0])


def parse(kind: str, data: str, element: str) -> Annotation:
    """Return the checked values of one annotation; `element` is named in errors. Raises SceneError."""
    if kind == UI_TEXT:
        try:
            return {**read_ui_text(data)}
        except ValueError as error:
            raise SceneError(f"text '{element}' must be {error}") from None
    keys = GRAMMAR[kind]
    values: Annotation = {}
    for word in data.split():
        key, sign, text = word.partition("=")
        is_free = kind in FREE and bool(key)
        if not sign or not (is_free or key in keys):
            raise SceneError(
                f"text '{element}' has '{_shortened(word)}'; valid is key=value with "
                + (f"a key of {', '.join(keys)}" if keys else "any key")
            )
        try:
            values[decode(key)] = FREE[kind](decode(text)) if is_free else keys[key](decode(text))
        except ValueError as error:
            raise SceneError(
                f"text '{element}' has '{_shortened(word)}'; valid for {key} is {error}"
            ) from None
    if kind == "proximity":
        _check_volume(values, element)
    elif kind == "ros2":
        check_keys(values, element, is_scene=element == f"{PREFIX}ros2:{WORLD}")
    return values


def _shortened(word: str) -> str:
    return word if len(word) <= _LONGEST_WORD else f"{word[:_LONGEST_WORD]}..."


def _check_volume(values: Annotation, element: str) -> None:
    kind = str(values.get("type", "ray"))
    needed, possible = VOLUMES[kind]
    given = values.keys() & _ANY_VOLUME
    if missing := [key for key in needed if key not in given]:
        raise SceneError(f"text '{element}' is of type {kind}, which needs {', '.join(missing)}")
    if surplus := sorted(given - {*needed, *possible}):
        valid = ", ".join((*needed, *possible)) or "no size"
        raise SceneError(f"text '{element}' is of type {kind}, which has no {surplus[0]}; it has {valid}")
    if kind == "cylinder" and not values["radius"] and not values.get("radius_far"):
        raise SceneError(f"text '{element}' has radius=0; then radius_far must be above 0")


def _split_name(full: str) -> tuple[str, str]:
    kind, sign, name = full.removeprefix(PREFIX).partition(":")
    if kind not in GRAMMAR or not sign or not name:
        raise SceneError(
            f"text '{full}' is not known; valid is '{PREFIX}KIND:OBJECT' with a KIND of {', '.join(GRAMMAR)}"
        )
    return kind, name
