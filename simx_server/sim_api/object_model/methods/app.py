"""Methods of the server: log, packing, images, plug-ins, events."""

from __future__ import annotations

import json
import struct
from typing import Any, cast

import numpy as np

from simx_server.errors import CommandError
from simx_server.scripting.conversion.signature import MOST_ITEMS
from simx_server.scripting.conversion.strings import with_texts
from simx_server.scripting.interpreter import Function
from simx_server.sim_api.object_model.enumerations import ENUMERATIONS
from simx_server.sim_api.object_model.values import from_script, to_script

from .method import Call, Options, method, number, option, text_option, whole

_ERROR, _WARNING, _INFO = 420, 430, 450
_UNDECORATED, _ONCE = 0xF000, 0x4000


def _log(call: Call, level: int, text: str | None, options: Options) -> None:
    bits = _UNDECORATED if option(options, "undecorated", False) else 0
    bits |= _ONCE if option(options, "once", False) else 0
    call.sim.addLog(level | bits, text)


@method("app", "logInfo", "changes")
def log_info(call: Call, text: str | None = None, options: Options = None) -> None:
    """Write a line to the status bar; options `undecorated` and `once`."""
    _log(call, _INFO, text, options)


@method("app", "logWarn", "changes")
def log_warning(call: Call, text: str | None = None, options: Options = None) -> None:
    """Write a warning to the status bar; options `undecorated` and `once`."""
    _log(call, _WARNING, text, options)


@method("app", "logError", "changes")
def log_error(call: Call, text: str | None = None, options: Options = None) -> None:
    """Write an error to the status bar; options `undecorated` and `once`."""
    _log(call, _ERROR, text, options)


@method("app", "getEnumInfo", "reads")
def get_enum_info(_call: Call, name: str) -> dict[str, Any]:
    """Return the numbers of an enumeration by name."""
    if name not in ENUMERATIONS:
        raise CommandError(f"'{name[:40]}' is no enumeration; those are {', '.join(ENUMERATIONS)}")
    return dict(ENUMERATIONS[name])


@method("app", "pack", "reads", takes_values=True)
def pack(call: Call, data: Any) -> Any:
    """Return a value as bytes, which unpack reads."""
    return call.sim.packTable([to_script(data)], 1)


@method("app", "unpack", "reads")
def unpack(call: Call, data: bytes) -> Any:
    """Return the value that pack has packed."""
    found = call.sim.unpackTable(data)
    return (
        from_script(with_texts(cast(list[Any], found)[0])) if isinstance(found, list) and found else None,
    )


@method("app", "serialize", "reads", takes_values=True)
def serialize(_call: Call, data: Any) -> Any:
    """Return a value as bytes of text, JSON, which deserialize reads."""
    try:
        return json.dumps(_texts(to_script(data)), separators=(",", ":"), sort_keys=True).encode()
    except (TypeError, ValueError) as problem:
        raise CommandError(f"the value cannot be serialized: {problem}") from None


def _texts(value: Any) -> Any:
    """Return a value without bytes, which JSON lacks."""
    if isinstance(value, bytes):
        return value.decode("utf-8", "surrogateescape")
    if isinstance(value, list):
        return [_texts(each) for each in cast(list[Any], value)]
    if isinstance(value, dict):
        return {str(key): _texts(each) for key, each in cast(dict[Any, Any], value).items()}
    return value


@method("app", "deserialize", "reads")
def deserialize(_call: Call, data: bytes) -> Any:
    """Return the value that serialize has packed."""
    try:
        return (from_script(json.loads(data)),)
    except (ValueError, RecursionError) as problem:
        raise CommandError(f"the bytes are not those of serialize: {problem}") from None


_FORMS = {"double": "d", "float": "f", "int64": "q", "int32": "i", "uint32": "I", "int16": "h", "uint16": "H",
          "int8": "b", "uint8": "B"}  # fmt: skip


def _form(options: Options) -> struct.Struct:
    word = text_option(options, "type", "double")
    if word not in _FORMS:
        raise CommandError(f"'{word[:40]}' is no type of packed numbers; those are {', '.join(_FORMS)}")
    return struct.Struct("<" + _FORMS[word])


def _part(values: list[Any], options: Options) -> list[Any]:
    start, count = whole(options, "start", 0), whole(options, "count", 0)
    if start < 0 or count < 0:
        raise CommandError("start and count are not below 0")
    return values[start : start + count if count else None]


@method("app", "packArray", "reads")
def pack_array(_call: Call, numbers: list[Any], options: Options = None) -> Any:
    """Return numbers as little-endian bytes; options `type`, `start`, `count`. Others than numbers become 0."""
    form = _form(options)
    is_real = form.format[-1] in "df"
    found = [each if isinstance(each, (int, float)) else 0 for each in _part(numbers, options)]
    try:
        return b"".join(form.pack(float(each) if is_real else int(each)) for each in found)
    except (struct.error, OverflowError, ValueError) as problem:
        raise CommandError(f"a number does not fit: {problem}") from None


@method("app", "unpackArray", "reads")
def unpack_array(_call: Call, data: bytes, options: Options = None) -> list[Any]:
    """Return the numbers of little-endian bytes; options `type`, `start`, `count`, `byteOffset`."""
    form, offset = _form(options), whole(options, "byteOffset", 0)
    if offset < 0:
        raise CommandError("byteOffset is not below 0")
    body = data[offset:]
    body = body[: len(body) // form.size * form.size]
    if len(body) // form.size > MOST_ITEMS:
        raise CommandError(f"at most {MOST_ITEMS} numbers are unpacked; give start and count of fewer bytes")
    return _part([each for (each,) in form.iter_unpack(body)], options)


@method("app", "systemLock", "needs a script")
def system_lock(call: Call, key: str, acquire: bool) -> Any:
    """Wait until no other script or server of this machine holds a key, and hold it; or release it."""
    return call.sim.systemSemaphore(key, acquire)


@method("app", "quit", "changes")
def quit_server(call: Call) -> None:
    """Stop the server, only while the simulation is stopped."""
    call.sim.quitSimulator()


@method("app", "scheduleExecution", "needs a script")
def schedule_execution(call: Call, function: Function, delay: float, options: Options = None) -> int:
    """Call a function after some seconds; options `args` and `simulationTime`. Return a number."""
    in_simulation = bool(option(options, "simulationTime", False))
    now = call.world.simulation.time if in_simulation else call.sim.getSystemTime()
    return call.sim.scheduleExecution(function, list(option(options, "args", [])), now + delay, in_simulation)


@method("app", "cancelScheduledExecution", "needs a script")
def cancel_scheduled_execution(call: Call, number: int) -> bool:
    """Cancel a scheduled call; return whether it was still to come."""
    return call.sim.cancelScheduledExecution(number)


@method("app", "pushEvent", "changes")
def push_event(call: Call, data: dict[str, Any], options: Options = None) -> None:
    """Send an event to all scripts with ``sysCall_event``; options `name`, `handle`, `uid`, `mergeable`."""
    numbers = (whole(options, "handle", -1), whole(options, "uid", -1))
    merged = int(bool(option(options, "mergeable", False)))
    call.sim.pushUserEvent(text_option(options, "name", "userEvent"), *numbers, data, merged)


@method("app", "getGenesisEvents", "reads")
def get_genesis_events(call: Call) -> Any:
    """Return events that describe the whole scene, as CBOR."""
    return call.sim.getGenesisEvents()


@method("app", "getPluginInfo", "reads")
def get_plugin_info(call: Call, name: str) -> dict[str, Any]:
    """Return version and date of a plug-in."""
    fields = (("extVersion", 0), ("buildDate", 1), ("extVersionInt", 2), ("consoleVerbosity", 3))
    return {field: call.sim.getPluginInfo(name, number) for field, number in fields}


@method("app", "setPluginInfo", "changes")
def set_plugin_info(call: Call, name: str, _info: dict[str, Any]) -> None:
    """Refuse: plug-ins are parts of the server."""
    call.sim.getPluginInfo(name, 0)
    raise CommandError("plug-ins are parts of the server, and their settings cannot be changed")


@method("app", "handleMessagePump", "changes")
def handle_message_pump(_call: Call) -> None:
    """Do nothing: the server answers others between and during calls."""


@method("app", "handleSandboxScript", "changes")
def handle_sandbox_script(call: Call, call_type: int) -> Any:
    """Do nothing: the sandbox script has no call-backs."""
    return call.sim.handleSandboxScript(call_type) and None


@method("app", "handleAddOnScripts", "changes")
def handle_add_on_scripts(call: Call, call_type: int) -> int:
    """Return 0: add-ons with call-backs of the simulation do not exist."""
    return call.sim.handleAddOnScripts(call_type)


@method("app", "fastIdleLoop", "changes")
def fast_idle_loop(_call: Call, _fast: bool) -> None:
    """Do nothing: the server never waits longer than its clients need."""


@method("app", "openFile", "changes")
def open_file(_call: Call, _file: str) -> None:
    """Refuse: the server has no window in which files could open."""
    raise CommandError("the server has no window in which a file could open")


# --- images ------------------------------------------------------------------------------------------


def _channels(image: bytes, resolution: list[int]) -> int:
    """Return how many bytes a pixel has. Raises CommandError."""
    pixels = resolution[0] * resolution[1] if len(resolution) == 2 else 0
    if pixels <= 0 or len(image) not in (pixels, 3 * pixels, 4 * pixels):
        raise CommandError(f"{len(image)} bytes are no image of {resolution}: it has 1, 3 or 4 bytes a pixel")
    return len(image) // pixels


def _with_colors(image: bytes, channels: int) -> tuple[bytes, int]:
    """Return an image with 3 or 4 bytes a pixel."""
    return (np.repeat(np.frombuffer(image, np.uint8), 3).tobytes(), 3) if channels == 1 else (image, channels)


@method("app", "loadImage", "reads")
def load_image(call: Call, file: bytes) -> Any:
    """Return pixels, resolution, and bytes of a pixel of an image file."""
    image, resolution = call.sim.loadImage(0, file)
    return image, resolution, _channels(image, resolution)


@method("app", "loadImageFromBuffer", "reads")
def load_image_from_buffer(call: Call, content: bytes) -> Any:
    """Return the same of the content of an image file."""
    return load_image(call, content + b"@mem")


@method("app", "saveImage", "writes files")
def save_image(call: Call, image: bytes, resolution: list[int], file: str, options: Options = None) -> None:
    """Write an image into a file of the workspace; option `quality`."""
    colored, channels = _with_colors(image, _channels(image, resolution))
    call.sim.saveImage(colored, resolution, int(channels == 4), file, whole(options, "quality", -1))


@method("app", "saveImageToBuffer", "reads")
def save_image_to_buffer(call: Call, image: bytes, resolution: list[int], options: Options = None) -> Any:
    """Return the content of an image file; options `format` and `quality`."""
    colored, channels = _with_colors(image, _channels(image, resolution))
    ending = text_option(options, "format", "png").lstrip(".")
    return call.sim.saveImage(
        colored, resolution, int(channels == 4), f".{ending}", whole(options, "quality", -1)
    )


_RATIOS = {"ignore": 0, "keep": 4, "keepExpand": 8}
_PIXELS = {"rgb": 3, "rgba": 4, "grey": 1}


@method("app", "transformImage", "reads")
def transform_image(
    call: Call, image: bytes, resolution: list[int], wanted: list[int] | None = None, options: Options = None
) -> Any:
    """Return an image, its resolution and bytes of a pixel; options `type`, `aspectRatio`, `smooth`, `flipAxisX`,
    `flipAxisY`.
    """
    kind, ratio = text_option(options, "type", "rgb"), text_option(options, "aspectRatio", "ignore")
    if kind not in _PIXELS or ratio not in _RATIOS:
        raise CommandError(f"types are {', '.join(_PIXELS)}, and aspect ratios {', '.join(_RATIOS)}")
    colored, channels = _with_colors(image, _channels(image, resolution))
    bits = int(channels == 4) | 2 * (kind == "rgba") | _RATIOS[ratio]
    bits |= 0 if option(options, "smooth", True) else 16
    made, size = call.sim.getScaledImage(colored, resolution, wanted or resolution, bits)
    flips = 2 * bool(option(options, "flipAxisX", False)) | 4 * bool(option(options, "flipAxisY", False))
    if flips:
        made = call.sim.transformImage(made, size, flips | (kind == "rgba"))
    if kind == "grey":
        made = (np.frombuffer(made, np.uint8).reshape(-1, 3).sum(axis=1) // 3).astype(np.uint8).tobytes()
    return made, size, _PIXELS[kind]


@method("app", "transformBuffer", "reads")
def transform_buffer(
    call: Call, data: bytes, in_format: int, out_format: int, options: Options = None
) -> Any:
    """Return every number times `scale` plus `offset`, in another format; option `clamp`."""
    clamp = 256 if option(options, "clamp", False) else 0
    numbers = (number(options, "scale", 1.0), number(options, "offset", 0.0))
    return call.sim.transformBuffer(data, in_format, *numbers, out_format | clamp)
