"""Filter chains of V-REP 3: the file's numbers as components with names.

A component has whole numbers, real numbers and a byte of switches. Their places are known from files for `binary`,
`blobs`, `coordinates` and `velodyne`; for the others they follow the functions of the vision plugin that replaced the
components, which take the same values.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from simx_server.scene.formats.texts.filter_chains import (
    COMPONENTS,
    Component,
    Value,
    read_chain,
    write_chain,
)
from simx_server.scene.formats.vrep.conversion.context import Conversion
from simx_server.scene.formats.vrep.objects import Filter, VisionSensor

IMAGE, DEPTH, OUTPUT = 1, 2, 4

_TRIGGERS = 0x0C
"""Bits of `binary`: each sensor that triggers has them."""


@dataclass(frozen=True)
class _Rule:
    """How the values of a component are found."""

    name: str
    values: Callable[[Filter], list[Value]] = lambda _: []
    is_sure: bool = True
    """False: the places of the switches are taken from the plugin's functions."""


def _reals(count: int) -> Callable[[Filter], list[Value]]:
    return lambda one: [*one.reals[:count]]


def _reals_and_bits(count: int, bits: int) -> Callable[[Filter], list[Value]]:
    return lambda one: [*one.reals[:count], *(_bit(one, 1 << bit) for bit in range(bits))]


def _matrix(side: int) -> Callable[[Filter], list[Value]]:
    count = side * side
    return lambda one: [*one.integers[:1], *one.reals[count : count + 1], *one.reals[:count]]


def _binary(one: Filter) -> list[Value]:
    return [*one.reals[:1], *one.reals[4:13], _bit(one, _TRIGGERS)]


def _bit(one: Filter, mask: int) -> bool:
    return bool(one.data and one.data[0] & mask)


_RULES = {
    IMAGE: _Rule("image"),
    DEPTH: _Rule("depth"),
    3: _Rule("uniform", _reals(3)),
    OUTPUT: _Rule("output"),
    5: _Rule("to_buffer1"),
    6: _Rule("to_buffer2"),
    7: _Rule("from_buffer1"),
    8: _Rule("from_buffer2"),
    9: _Rule("swap_buffers"),
    10: _Rule("add_buffer1"),
    11: _Rule("subtract_buffer1"),
    12: _Rule("multiply_with_buffer1"),
    13: _Rule("flip_horizontally"),
    14: _Rule("flip_vertically"),
    15: _Rule("rotate", _reals(1)),
    16: _Rule("shift", _reals_and_bits(2, 1), is_sure=False),
    17: _Rule("resize", _reals(2)),
    18: _Rule("matrix3", _matrix(3)),
    19: _Rule("matrix5", _matrix(5)),
    20: _Rule("sharpen"),
    21: _Rule("edges", _reals(1)),
    22: _Rule("rectangle", _reals_and_bits(2, 1), is_sure=False),
    23: _Rule("circle", _reals_and_bits(1, 1), is_sure=False),
    24: _Rule("normalise"),
    25: _Rule("intensity_scale", _reals_and_bits(2, 1), is_sure=False),
    26: _Rule("select_colour", _reals_and_bits(6, 3), is_sure=False),
    27: _Rule("scale_colours", _reals_and_bits(9, 1), is_sure=False),
    28: _Rule("binary", _binary),
    29: _Rule("swap_with_buffer1"),
    30: _Rule("add_to_buffer1"),
    31: _Rule("subtract_from_buffer1"),
    33: _Rule("merge_colours", _reals(1)),
    34: _Rule("blobs", _reals_and_bits(2, 1)),
    35: _Rule("coordinates", lambda one: [*one.integers[:2], _bit(one, 1)]),
    36: _Rule("changes", _reals(1)),
    37: _Rule("velodyne", lambda one: [*one.integers[:2], *one.reals[:1]]),
    38: _Rule("output_depth"),
}


def is_plain(sensor: VisionSensor) -> bool:
    """Return whether the image is the sensor's own: without a chain, or with one that copies it."""
    return sensor.filters is None or _kinds(sensor) == [IMAGE, OUTPUT]


def shows_depth(sensor: VisionSensor) -> bool:
    """Return whether the chain only shows the depth in grey."""
    return _kinds(sensor) == [DEPTH, OUTPUT]


def chain_text(conversion: Conversion, sensor: VisionSensor) -> str:
    """Return the chain of a sensor as an annotation has it; components that cannot be applied are left out."""
    found: list[Component] = []
    for one in sensor.filters or []:
        if not one.enabled:
            continue
        rule = _RULES.get(one.type)
        component = None if rule is None else _component(rule, one)
        if rule is None or component is None:
            reason = "is not known" if rule is None else f"({rule.name}) has unusable values"
            _leave_out(conversion, sensor, f"component {one.type} {reason}")
            continue
        if not rule.is_sure:
            conversion.report.approximate(
                f"filter component {one.type} ({rule.name}) of vision sensors: its switches are read in the order of "
                "the vision plugin's function",
                conversion.name(sensor),
            )
        found.append(component)
    return write_chain(found)


def _kinds(sensor: VisionSensor) -> list[int]:
    return [one.type for one in sensor.filters or [] if one.enabled]


def _component(rule: _Rule, one: Filter) -> Component | None:
    """Return a component with valid values, or None."""
    values = rule.values(one)
    if len(values) != len(COMPONENTS[rule.name]) or not all(math.isfinite(value) for value in values):
        return None
    text = write_chain([Component(rule.name, tuple(values))])
    try:
        (component,) = read_chain(text)
    except ValueError:
        return None
    return component


def _leave_out(conversion: Conversion, sensor: VisionSensor, reason: str) -> None:
    conversion.report.leave_out(
        f"filters of vision sensors: {reason}; the rest of the chain is applied", conversion.name(sensor)
    )
