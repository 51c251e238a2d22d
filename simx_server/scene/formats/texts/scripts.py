"""Annotations of scripts in `<custom>`.

`<text name="simx:script:OBJECT" data="file=arm.lua type=customization"/>` names a file beside the scene; the type is
child (the default), customization or main. `<text name="simx:lua:OBJECT" data="..."/>` and `simx:python:OBJECT`
contain the script itself; a line break in the XML attribute is a real one or `&#10;`, quotes are `&quot;`, `<` is
`&lt;`.

An object may have one child script and one customization script: as names of MuJoCo's texts are unique, the second
needs the type in its name, `simx:script:customization:OBJECT`, `simx:lua:customization:OBJECT`. `threaded` in that
place (or `threaded=yes` beside `file=`) is a child script that runs as a thread. A main script does not belong to an
object: `simx:lua:main`, or `type=main`.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

SCRIPT_TYPES = ("child", "customization", "main")

SCRIPT_NOTES: Mapping[str, str] = MappingProxyType(
    {"script": "child", "customization script": "customization"}
)
"""Kind of annotation that contains an object's script, and the script's type."""

TEXT_KINDS = ("lua", "python")
"""Kinds whose data are the script itself."""

_THREADED = "threaded"


def place_script(name: str, note: dict[str, float | bool | str]) -> tuple[str, str]:
    """Return the object ('' for a main script) of a script annotated as `name`, and the kind that stores it.

    Adds to `note` the ``type`` and ``threaded`` that the name contains.
    """
    word, sign, rest = name.partition(":")
    if name == "main" and "type" not in note:
        note["type"] = "main"
    elif sign and word in (*SCRIPT_TYPES, _THREADED):
        name = rest
        note["type"] = "child" if word == _THREADED else word
        if word == _THREADED:
            note[_THREADED] = True
    kind = str(note.setdefault("type", "child"))
    if kind == "main":
        return "", "main script"
    return name, next(key for key, script_type in SCRIPT_NOTES.items() if script_type == kind)
