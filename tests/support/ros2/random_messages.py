"""Messages with random values, for comparisons with other implementations."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

import numpy as np

from simx_server.ros2_messages.layouts import Field, Layout
from simx_server.ros2_messages.primitives import Primitive

LONGEST = 12
"""Strings have fewer characters."""


def made(layout: Layout, rng: random.Random) -> dict[str, Any]:
    """Return a message with random values, strings and lengths."""

    def one(field: Field) -> Any:
        if isinstance(field.kind, Layout):
            return made(field.kind, rng)
        if not isinstance(field.kind, Primitive):
            return "".join(
                rng.choices("abcdefgh/_äß", k=rng.randrange(min(LONGEST, field.longest or LONGEST)))
            )
        if field.kind.letter == "?":
            return rng.random() < 0.5
        if field.kind.least is None or field.kind.most is None:
            return rng.randrange(-1000, 1000) / 8
        # rosbags takes a single byte for a signed one; the bytes are the same.
        return rng.randint(field.kind.least, 127 if field.kind.name == "byte" else field.kind.most)

    def value(field: Field) -> Any:
        if field.count is None:
            return one(field)
        return [one(field) for _ in range(field.count or rng.randrange(field.most + 1 if field.most else 5))]

    return {field.name: value(field) for field in layout.fields}


def plain(value: Any) -> Any:
    """Return a decoded message with lists in place of arrays."""
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [plain(item) for item in value] if isinstance(value, list) else value


def for_rosbags(store: Any, layout: Layout, value: Mapping[str, Any]) -> Any:
    """Return the message as an object of rosbags."""

    def converted(field: Field, item: Any) -> Any:
        if isinstance(field.kind, Layout):
            if field.count is None:
                return for_rosbags(store, field.kind, item)
            return [for_rosbags(store, field.kind, one) for one in item]
        if field.count is not None and isinstance(field.kind, Primitive):
            return np.array(item, field.kind.dtype)
        return item

    fields = {field.name: converted(field, value[field.name]) for field in layout.fields}
    return store.types[layout.name](**fields)
