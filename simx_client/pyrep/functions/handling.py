"""Functions of sensors and contacts that return more than numbers: images, packets of statistics, contacts."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import c_values as c
from ..plain import Call
from .registry import c_function

_AS_STRING = 1
"""Option of sim.getVisionSensorImage: bytes in place of a table."""

_CODED_STRING = 0x400000
"""sim.handleflag_codedstring: bytes in place of a table, for depths."""


@c_function()
def simHandleVisionSensor(call: Call, sensor: int, values: c.C, counts: c.C) -> int:
    """Render; return whether the sensor detects, and write its packets of statistics."""
    return _packets(call("sim.handleVisionSensor", [int(sensor)]), values, counts)


@c_function()
def simReadVisionSensor(call: Call, sensor: int, values: c.C, counts: c.C) -> int:
    """Return what the last handling found, as simHandleVisionSensor."""
    return _packets(call("sim.readVisionSensor", [int(sensor)]), values, counts)


def _packets(results: tuple[Any, ...], values: c.C, counts: c.C) -> int:
    state, packets = results[0], [each for each in results[1:] if each]
    numbers = c.array("float", [number for packet in packets for number in packet])
    sizes = c.array("int", [len(packets), *map(len, packets)])
    c.keep("packets", numbers, sizes)
    c.fill_pointer(values, numbers)
    c.fill_pointer(counts, sizes)
    return int(state)


@c_function(c.NULL)
def simGetVisionSensorImage(call: Call, sensor: int) -> c.C:
    """Return the pixels of an image, 0 to 1, red, green, blue, the lowest row first.

    Programs decode masks from these numbers.
    """
    (pixels,) = call("sim.getVisionSensorImage", [int(sensor), 0, 0, 0, 0, _AS_STRING])
    numbers = np.frombuffer(pixels, np.uint8).astype(np.float32)
    numbers /= np.float32(255.0)
    return c.ffi.from_buffer("float[]", numbers)


@c_function(c.NULL)
def simGetVisionSensorDepthBuffer(call: Call, sensor: int) -> c.C:
    """Return depths: 0 at the near plane and 1 at the far one, or metres with the flag for that."""
    (depth,) = call("sim.getVisionSensorDepthBuffer", [int(sensor) | _CODED_STRING])
    return c.ffi.from_buffer("float[]", bytearray(depth))


@c_function()
def simGetContactInfo(call: Call, step: int, handle: int, index: int, objects: c.C, contact: c.C) -> int:
    """Write a contact by its index: two objects, the point, the force, the normal; return 0 behind the last one."""
    found = call("sim.getContactInfo", [int(step), int(handle), int(index)])
    if not found or found[0] is None:
        return 0
    pair, *vectors = found
    c.fill(objects, pair)
    c.fill(contact, [number for vector in vectors for number in vector])
    return 1
