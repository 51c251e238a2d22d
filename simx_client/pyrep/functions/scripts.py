"""A call of a function of a script, or of an add-on, with four tables in and four out."""

from __future__ import annotations

from typing import Any

from .. import c_values as c
from ..plain import Call
from .registry import c_function


@c_function()
def simExtCallScriptFunction(
    call: Call, script: int, name: Any, ints: Any, int_count: int, floats: Any, float_count: int, texts: Any,
    text_count: int, buffer: Any, buffer_size: int, out_ints: c.C, out_int_count: c.C, out_floats: c.C,
    out_float_count: c.C, out_texts: c.C, out_text_count: c.C, out_buffer: c.C, out_buffer_size: c.C,
) -> int:  # fmt: skip
    """Call ``NAME@SCRIPT`` by the script's type or handle."""
    results = call(
        "sim.callScriptFunction",
        [
            c.text(name),
            int(script),
            (c.integers(ints) or [])[:int_count],
            (c.floats(floats) or [])[:float_count],
            [c.text(texts[number]) for number in range(text_count)],
            (c.content(buffer) or b"")[:buffer_size],
        ],
    )
    missing: list[Any] = [[], [], [], b""]
    some_ints, some_floats, some_texts, some_bytes = [*results, *missing[len(results) :]][:4]
    table, kept = c.strings(some_texts or [])
    values = c.array("int", some_ints or []), c.array("float", some_floats or []), c.string(some_bytes or b"")
    c.keep("simExtCallScriptFunction", values, table, kept)
    for target, value in zip((out_ints, out_floats, out_buffer, out_texts), (*values, table), strict=True):
        c.fill_pointer(target, value)
    for target, some in (
        (out_int_count, some_ints),
        (out_float_count, some_floats),
        (out_text_count, some_texts),
        (out_buffer_size, some_bytes),
    ):
        target[0] = len(some or ())
    return 1
