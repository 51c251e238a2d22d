"""Write annotations into a spec, from which `reading.py` reads the same values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from simx_server.scene.formats.texts.old_uis import UI_TEXT
from simx_server.scene.formats.texts.scripts import SCRIPT_NOTES
from simx_server.scene.formats.texts.values import encode, encode_key

from .annotation import PREFIX, Annotation, Annotations, Value
from .grammar import WORLD

if TYPE_CHECKING:
    import mujoco

_MAIN = "main"
_IN_TEXT = ("text", "language", "type")
"""Keys of a script's annotation that its text and its name hold."""


def write_annotations(spec: mujoco.MjSpec, annotations: Annotations) -> None:
    """Replace all annotations of a spec."""
    step = PREFIX + "time_step"
    if (numeric := spec.numeric(step)) is not None:
        spec.delete(numeric)
    if annotations.time_step is not None:
        spec.add_numeric(name=step, data=[annotations.time_step], size=1)
    texts = [(name, data) for name, data in _texts(annotations) if data]  # MuJoCo takes no empty text
    present = [text for text in spec.texts if text.name.startswith(PREFIX)]
    for number, text in enumerate(present):  # deleting an element takes as long as the spec is large
        text.name = f"{PREFIX}{number}"
    for text, (name, data) in zip(present, texts, strict=False):
        text.name, text.data = name, data
    for name, data in texts[len(present) :]:
        spec.add_text(name=name, data=data)
    for text in present[len(texts) :]:
        spec.delete(text)


def _texts(annotations: Annotations) -> Iterator[tuple[str, str]]:
    """Yield the name and the data of each text."""
    for kind, note in (("scene", annotations.scene), ("data", annotations.data), ("ros2", annotations.ros2)):
        yield f"{PREFIX}{kind}:{WORLD}", note_text(note)
    if annotations.main_script is not None:
        yield from _script(_MAIN, annotations.main_script)
    for name, notes in annotations.objects.items():
        for kind, note in notes.items():
            if kind in SCRIPT_NOTES:
                yield from _script(f"{SCRIPT_NOTES[kind]}:{name}", note)
            else:
                yield f"{PREFIX}{kind}:{name}", note_text(note)
    for kind, entries in annotations.registered.items():
        for name, note in entries.items():
            yield f"{PREFIX}{kind}:{name}", str(note["text"]) if kind == UI_TEXT else note_text(note)


def _script(place: str, note: Annotation) -> Iterator[tuple[str, str]]:
    if "text" in note:
        yield f"{PREFIX}{note.get('language', 'lua')}:{place}", str(note["text"]) or " "
    yield f"{PREFIX}script:{place}", note_text({key: note[key] for key in note if key not in _IN_TEXT})


def note_text(note: Mapping[str, Value]) -> str:
    """Return the data of an annotation."""
    return " ".join(f"{encode_key(key)}={encode(_text(value))}" for key, value in note.items())


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return repr(value).removesuffix(".0") if isinstance(value, float) else str(value)
