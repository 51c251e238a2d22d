"""The scripts of a V-REP file, as texts beside their objects.

A script of CoppeliaSim 4.7 and later lies in a script object, and serves that object's parent; the server knows that
rule for objects of type script. The simulator's own main script is left out: the server has one.
"""

from __future__ import annotations

from simx_server.scene.formats.annotations import PREFIX
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Joint, Script
from simx_server.scene.formats.vrep.script_needs import needs_of

from .old_call_backs import (
    CHILD,
    CONTACT,
    CUSTOMIZATION,
    JOINT,
    MAIN,
    kind_of,
    with_call_back,
)

_MOVING_FRAMES = (4, 0, 1)
"""First version in which a pose relative to a joint is one in its moving frame."""

_FULL_RESULTS = (4, 3, 0)
"""First version in which functions of proximity sensors return all their values also where nothing is detected."""

_ERRORS_RAISED = (3, 4, 0)
"""First version that is known to stop a script at an error of the API; V-REP 3.1.2 only printed the error."""

_ORDERS = ("first", "normal", "last")
_TRAVERSALS = ("reverse", "forward", "parent")

_CONTACT_OBJECT = "contactCallbackScript"
"""Name of the script object that is made for a contact call-back script, which has none in the file."""


def add_scripts(conversion: Conversion) -> None:
    """Add the texts, and note what they need."""
    taken: set[tuple[str, int]] = set()
    for script in conversion.file.scripts:
        if not script.text.strip() or (script.type == MAIN and script.is_default_main):
            continue
        name = _home(conversion, script)
        if name is None:
            continue
        kind = script.type if script.type in (MAIN, CUSTOMIZATION) else CHILD
        if (name, kind) in taken:
            conversion.report.leave_out("an object has one script of a kind; further ones are left out", name)
            continue
        taken.add((name, kind))
        _add(conversion, script, name)


def _home(conversion: Conversion, script: Script) -> str | None:
    """Return the name under which a script is annotated: that of an object, or main; None for one without a place."""
    report = conversion.report
    if script.type == MAIN:
        return "main"
    if _kind(conversion, script) == CONTACT:
        return _contact_object(conversion)
    if script.type not in (CHILD, JOINT, CUSTOMIZATION):
        report.leave_out(f"scripts of type {script.type} do not run")
        return None
    home = _object_of(conversion, script)
    if home is None:
        report.leave_out("scripts that belong to no object of the file do not run")
        return None
    return conversion.names[home]


def _object_of(conversion: Conversion, script: Script) -> int | None:
    """Return the object in which a script lies, or the one that it serves; None: there is neither."""
    return next((each for each in (script.object, script.owner) if each in conversion.names), None)


def _kind(conversion: Conversion, script: Script) -> int:
    home = _object_of(conversion, script)
    has_joint = home is not None and isinstance(conversion.file.objects[home], Joint)
    return kind_of(script.type, script.text, has_joint=has_joint)


def _contact_object(conversion: Conversion) -> str:
    """Add a script object at the top of the scene; return its name."""
    name = _CONTACT_OBJECT
    while name in conversion.names.values():
        name += "_"
    if conversion.spec.site(name) is None:
        conversion.spec.worldbody.add_site(name=name, group=5)
        conversion.annotate("object", name, type="script")
    return name


def _add(conversion: Conversion, script: Script, name: str) -> None:
    kind = "customization:" if script.type == CUSTOMIZATION else ""
    text = with_call_back(_kind(conversion, script), script.text.replace("\0", ""))
    conversion.spec.add_text(name=f"{PREFIX}{script.language}:{kind}{name}", data=text)
    goes_on = conversion.file.program < _ERRORS_RAISED
    if script.type == MAIN:
        if goes_on:
            conversion.annotate("script", name, stops_at_errors=False)
    else:
        options = {"threaded": True} if script.is_threaded else {}
        options |= {"enabled": False} if script.is_disabled else {}
        options |= {"order": _ORDERS[script.order]} if script.order != 1 else {}
        options |= {"traversal": _TRAVERSALS[script.traversal]} if script.traversal else {}
        options |= options_of_version(conversion.file.program)
        if options:
            conversion.annotate("script", f"{kind}{name}", **options)
    shown = "main script" if script.type == MAIN else f"{_words(script)} of '{name}'"
    if not script.is_disabled:
        conversion.report.needs[shown] = needs_of(text, script.language)


def options_of_version(program: tuple[int, int, int]) -> dict[str, bool]:
    """Return the options of all scripts of a file by the version of its program, where they are not the usual ones."""
    options = {"joint_bases": True} if program < _MOVING_FRAMES else {}
    options |= {"full_results": True} if program >= _FULL_RESULTS else {}
    return options | ({"stops_at_errors": False} if program < _ERRORS_RAISED else {})


def _words(script: Script) -> str:
    return "customization script" if script.type == CUSTOMIZATION else "child script"
