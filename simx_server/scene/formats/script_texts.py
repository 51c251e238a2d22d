"""What `<custom>` says of scripts.

`<text name="simx:script:OBJECT" data="file=arm.lua type=customization"/>` names a file beside the scene; the type is
child (without saying so), customization or main. `<text name="simx:lua:OBJECT" data="..."/>` and `simx:python:OBJECT`
hold the script itself; a line break in the XML attribute is a real one or `&#10;`, quotes are `&quot;`, `<` is `&lt;`.

An object may have one child script and one customization script: as names of MuJoCo's texts are unique, the second
needs the type in its name, `simx:script:customization:OBJECT`, `simx:lua:customization:OBJECT`. `threaded` in that
place (or `threaded=yes` beside `file=`) is a child script that is one thread. A main script belongs to no object:
`simx:lua:main`, or `type=main`.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

SCRIPT_TYPES = ("child", "customization", "main")

SCRIPT_NOTES: Mapping[str, str] = MappingProxyType(
    {"script": "child", "customization script": "customization"}
)
"""Under which kind an object's annotations keep a script, and its type."""

TEXT_KINDS = ("lua", "python")
"""Kinds whose data are the script itself."""

_THREADED = "threaded"


def place_script(name: str, note: dict[str, float | bool | str]) -> tuple[str, str]:
    """The object (nothing for a main script) and the kind under which to keep a script that was annotated as `name`.

    Completes `note` by what the name says: ``type`` and ``threaded``.
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
