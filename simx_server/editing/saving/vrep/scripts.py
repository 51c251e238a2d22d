"""Scripts: which of a file's scripts are there still, which have changed, and which are new."""

from __future__ import annotations

from collections.abc import Mapping

from simx_server.scene.formats.annotations import Annotation
from simx_server.scene.formats.vrep.conversion.facts.old_call_backs import CHILD, CUSTOMIZATION
from simx_server.scene.formats.vrep.decoding.scripts import DISABLED, THREADED, unmasked
from simx_server.scene.formats.vrep.writing.record_lists import END, RecordList, parse_list
from simx_server.scene.formats.vrep.writing.script_texts import masked

from .field import NotInVrepFiles

KINDS = {"script": CHILD, "customization script": CUSTOMIZATION}
"""Annotations of scripts, and their types in files."""

_DEFAULTS: Annotation = {
    "text": "", "language": "lua", "threaded": False, "enabled": True, "order": "normal", "traversal": "reverse",
}  # fmt: skip
"""Options that files have, and their values where an annotation lacks them."""

_ORDERS = ("first", "normal", "last")
_TRAVERSALS = ("reverse", "forward", "parent")

_FIRST_WITH_LANGUAGE = 25
"""Version of the format from which scripts name their language."""


def kind_of(script: RecordList) -> int:
    """Return the type of a script in a file."""
    return int((script.numbers("Si2") or [-1, -1, -1])[2])


def place_of(script: RecordList) -> int:
    """Return the object that a script names, -1 for none."""
    chosen = int((script.numbers("Coc") or [-1])[0])
    return chosen if chosen >= 0 else int((script.numbers("Si2") or [-1, -1, -1])[1])


def is_same(one: Annotation | None, other: Annotation | None) -> bool:
    """Return whether two scripts have the same text and options, as far as files have them."""
    return one is other or (one is not None and other is not None and _options(one) == _options(other))


def _options(note: Annotation) -> Annotation:
    found = {key: note.get(key, default) for key, default in _DEFAULTS.items()}
    return {**found, "text": str(found["text"]).rstrip()}


def change(script: RecordList, note: Annotation, before: Annotation | None) -> None:
    """Write the text and the options of a script that differ from what they were; None: all of them.

    Raises:
        NotInVrepFiles: the text is that of an old call-back, which the server has replaced.
    """
    new, old = _options(note), {} if before is None else _options(before)
    if new["text"] != old.get("text"):
        is_translated = (
            before is not None and unmasked(script.raw("Ste") or b"").strip() != str(old["text"]).strip()
        )
        if is_translated:
            raise NotInVrepFiles("a changed script that was an old call-back")
        script.put("Ste", masked(str(new["text"])))
    if new["language"] != old.get("language") and script.serialization >= _FIRST_WITH_LANGUAGE:
        script.put_text("Lne", str(new["language"]))
    if (new["threaded"], new["enabled"]) != (old.get("threaded"), old.get("enabled")):
        bits = THREADED * bool(new["threaded"]) | DISABLED * (not new["enabled"])
        script.put_bits("Va2", THREADED | DISABLED, bits)
    if new["order"] != old.get("order"):
        script.put_numbers("Seo", _ORDERS.index(str(new["order"])))
    if new["traversal"] != old.get("traversal") and (script.has("Ttd") or new["traversal"] != "reverse"):
        script.put_numbers("Ttd", _TRAVERSALS.index(str(new["traversal"])))


def rename_owner(script: RecordList, number: int, owner: int) -> None:
    """Give a script another number, and the object in which it lies."""
    script.put_numbers("Si2", number, owner, None)
    if script.has("Coc"):
        script.put_numbers("Coc", owner)


def new_script(kind: int, number: int, owner: int, note: Annotation, serialization: int) -> RecordList:
    """Return a script that no file had."""
    script = RecordList("script", serialization)
    script.put_numbers("Si2", number, owner, kind)
    script.put_numbers("Coc", owner)
    change(script, note, None)
    return script


def parse_script(payload: bytes, serialization: int) -> RecordList:
    """Return the records of a script. Raises SceneError."""
    return parse_list("script", payload, serialization)


def script_bytes(script: RecordList) -> bytes:
    """Return the payload of a script."""
    return bytes(script) + END


def noted_kinds(notes: Mapping[str, Annotation]) -> dict[int, Annotation]:
    """Return the scripts of an object by their types in files."""
    return {KINDS[kind]: note for kind, note in notes.items() if kind in KINDS}
