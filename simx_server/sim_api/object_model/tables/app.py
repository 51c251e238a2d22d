"""Properties of the server, ``sim.app``."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import mujoco

import simx_server
from simx_server.scripting import modules
from simx_server.sim_api.object_model.enumerations import ENUMERATIONS
from simx_server.sim_api.object_model.instances.custom import classes, custom_objects
from simx_server.sim_api.object_model.types import enum_of
from simx_server.sim_api.properties import property_types as t
from simx_server.sim_api.properties.entry import Property, fixed
from simx_server.sim_api.properties.tables.scene import OF_APP

from .making import Old, constant, kept, refused

if TYPE_CHECKING:
    from simx_server.world.world import World

PROGRAM_VERSION = 41000
"""Of the CoppeliaSim whose functions programs find here: 4.10.0."""

EVENTS_VERSION = 3
"""Of the events that scripts get, CoppeliaSim 4.10's."""

_LEVELS = "the log has the levels of the server's flag --log-level"
_MACHINE = "this server has no licence that is tied to a machine"
_NO_ADD_ON = "add-ons are started by the server's flag --add-on"
_OLD = Old(OF_APP)
_PACKAGE = Path(simx_server.__file__).parent
_LETTERS = "0123456789abcdef"


def _random_text(world: World, handle: int) -> str:
    """Return 16 hexadecimal digits, from the same sequence as randomFloat."""
    get = _OLD["randomFloat"].get
    assert get is not None
    return "".join(_LETTERS[int(16 * get(world, handle)) % 16] for _ in range(16))


def _temp(world: World, handle: int) -> str:
    get = _OLD["tempPath"].get
    assert get is not None
    return str(get(world, handle))


def _classes(world: World, *, of_scene: bool) -> list[int]:
    """Return the classes that programs have made, of scene objects or of others."""
    return [each.handle for each in classes(world) if bool(each.model) == of_scene]


APP = (
    *_OLD.same("browserEnabled canSave displayEnabled execUnsafe execUnsafeExt hierarchyEnabled idleFps"),
    *_OLD.same("pluginNames productVersion randomFloat randomQuaternion"),
    constant("productVersionNb", t.INT, PROGRAM_VERSION),
    _OLD.named("appArgs", "args"),
    _OLD.enumerated("headlessMode", "headlessMode", "headlessMode"),
    _OLD.enumerated("platform", "platform", "platform"),
    constant("flavor", enum_of("appFlavor"), ENUMERATIONS["appFlavor"]["edu"]),
    constant("addOns", t.HANDLE_ARRAY, []),
    Property("customClasses", t.HANDLE_ARRAY, lambda world, _handle: _classes(world, of_scene=False)),
    Property(
        "customSceneObjectClasses", t.HANDLE_ARRAY, lambda world, _handle: _classes(world, of_scene=True)
    ),
    Property("customObjects", t.HANDLE_ARRAY, lambda world, _handle: custom_objects(world, in_app=True)),
    constant("enumTypes", t.STRING_ARRAY, list(ENUMERATIONS)),
    constant("defaultPython", t.STRING, sys.executable),
    constant("notifyDeprecated", t.INT, 0),
    constant("processCnt", t.INT, 1),
    constant("processId", t.INT, 0),
    constant("protocolVersion", t.INT, EVENTS_VERSION),
    Property("pid", t.LONG, lambda _world, _handle: os.getpid()),
    Property("sessionId", t.STRING, lambda world, _handle: f"{os.getpid():x}-{world.simulation.scene_id:x}"),
    Property("systemTime", t.FLOAT, lambda _world, _handle: time.monotonic()),
    Property("randomString", t.STRING, _random_text),
    Property("sandbox", t.HANDLE, lambda world, _handle: world.scripts.sandbox.handle),
    constant("sandboxLang", t.STRING, "lua"),
    _OLD.named("appPath", "paths.app"),
    _OLD.named("modelPath", "paths.models"),
    _OLD.named("scenePath", "paths.scenes"),
    _OLD.named("scenePath", "paths.importExport"),
    _OLD.named("tempPath", "paths.temp"),
    Property("paths.sceneTemp", t.STRING, _temp),
    constant("paths.lua", t.STRING, str(Path(modules.__file__).parent / "lua")),
    constant("paths.python", t.STRING, str(Path(modules.__file__).parent / "python")),
    constant("paths.resources", t.STRING, str(_PACKAGE)),
    constant("paths.system", t.STRING, str(_PACKAGE)),
    constant("paths.mujoco", t.STRING, str(Path(mujoco.__file__).parent)),
    *(fixed(name, t.STRING, "", _NO_ADD_ON) for name in ("auxAddOn1", "auxAddOn2", "startupCode")),
    refused("paths.addOns", t.STRING, _NO_ADD_ON),
    refused("paths.settings", t.STRING, "settings are the server's flags and variables"),
    *(
        kept(f"default{name}StepSize", t.FLOAT, first)
        for name, first in (("Rotation", 0.0873), ("Translation", 0.05))
    ),
    *(refused(f"{name}Verbosity", t.INT, _LEVELS) for name in ("console", "dialog", "statusbar")),
    *(refused(f"{name}VerbosityStr", t.STRING, _LEVELS) for name in ("console", "dialog", "statusbar")),
    *(refused(f"machineId{end}", t.STRING, _MACHINE) for end in ("", "0", "1", "2", "3", "X")),
    *(refused(name, t.STRING, _MACHINE) for name in ("legacyMachineId", "machineSerial", "machineSerialND")),
    *(refused(name, t.STRING, _MACHINE) for name in ("dongleId", "dongleSerial")),
    refused("qtVersion", t.INT, "the server does not use Qt"),
)
