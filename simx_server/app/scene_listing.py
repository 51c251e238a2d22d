"""``simx-server SCENE --tree``: list the objects of a scene as scripts will find them, for people and for programs.

The scene is loaded as a server with the same flags would load it, so its customization scripts have started and handles
are those that clients will get. The simulation does not run, and no client can connect.
"""

from __future__ import annotations

import json
import logging
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

from simx_client.protocol.cli.exit_codes import DONE, FAILURE
from simx_client.protocol.cli.terminal import Paint
from simx_server.errors import CommandError
from simx_server.scene.formats.annotations import REGISTERED
from simx_server.scene.object_listing import list_objects
from simx_server.scripting.interpreter import ScriptError
from simx_server.scripting.outline import functions_in, signals_in
from simx_server.scripting.script import Script
from simx_server.settings.settings import Settings
from simx_server.simulation.simulation import Simulation
from simx_server.world.world import World

from .server import open_world

logger = logging.getLogger(__name__)


def print_tree(settings: Settings, *, as_json: bool) -> int:
    """Load the scene that the settings name, and print it. Returns the exit code."""
    with ExitStack() as stack:
        try:
            world = open_world(settings, stack)
        except CommandError as error:
            logger.error("%s", error)
            return FAILURE
        record = as_record(world)
    text = json.dumps(record, indent=1) if as_json else "\n".join(as_lines(record, Paint(sys.stdout)))
    sys.stdout.write(text + "\n")
    return DONE


def as_record(world: World) -> dict[str, Any]:
    """Return the scene for programs: name, file, objects in tree order, main script, registered names per kind."""
    scene = world.simulation.scene
    scripts: dict[int, list[dict[str, Any]]] = {}
    for script in world.scripts.all():
        # A script object at the top serves no object, but its script is not a main script.
        place = script.owner if script.owner != -1 else script.home
        scripts.setdefault(place, []).append(_script(world.simulation, script))
    return {
        "scene": scene.name,
        "file": str(scene.path) if scene.path is not None else None,
        "objects": [
            {**each, "scripts": scripts.get(each["handle"], [])} for each in list_objects(world.simulation)
        ],
        "main_script": scripts.get(-1, []),
        "registered": {kind: sorted(scene.annotations.registered.get(kind, ())) for kind in REGISTERED},
    }


def as_lines(record: dict[str, Any], paint: Paint) -> Iterator[str]:
    """Yield the same for people: one line per object, children indented under their parent."""
    objects = record["objects"]
    yield f"{record['scene']}: {len(objects)} objects" + (f" ({record['file']})" if record["file"] else "")
    width = max((2 * each["depth"] + len(each["name"]) for each in objects), default=0)
    types = max((len(_type(each)) for each in objects), default=0)
    for each in objects:
        indented = f"{'  ' * each['depth']}{each['name']}"
        line = (
            f"{paint(format(each['handle'], '6d'), 'grey')}  {indented:{width}}  "
            f"{paint(format(_type(each), str(types)), 'blue')}"
        )
        notes = [f"{one['type']} script {one['file']}" for one in each["scripts"]]
        if each["is_model"]:
            notes.insert(0, "model")
        yield (line + "  " + ", ".join(notes)).rstrip()
    for script in record["main_script"]:
        yield f"main script {script['file']}"
    for kind, names in record["registered"].items():
        if names:
            yield f"{kind}: {', '.join(names)}"


def _type(each: dict[str, Any]) -> str:
    detail = each.get("joint") or "x".join(map(str, each.get("resolution", ())))
    return f"{each['type']} {detail}".rstrip()


def _script(simulation: Simulation, script: Script) -> dict[str, Any]:
    try:
        text = script.source(simulation).decode("utf-8", "replace")
    except (ScriptError, CommandError) as error:
        logger.warning("%s", error)
        text = ""
    return {
        "type": script.kind.text.removesuffix(" script"),
        "file": script.file,
        "language": script.language,
        "functions": functions_in(text, script.language),
        "signals": signals_in(text, script.language),
    }
